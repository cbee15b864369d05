//! The panels driven without a window: pointer events at controls that are found by their names.

use super::*;
use crate::session::{Compare, Side};
use crate::widgets::{Widgets, moved, pressed};
use crate::worker::{Event, Frame, Pass, SceneFacts};
use egui::{PointerButton, RawInput, Rect};
use frame::cpu::Image;
use gridlight::RenderSettings;
use gridlight::cli::RenderLine;
use gridlight::stages::{KnobInfo, KnobKind};
use std::sync::Arc;

struct Bench {
    context: egui::Context,
    session: Session,
    shown: Shown,
    screen: Screen,
    store: Store,
    actions: Vec<Action>,
    widgets: Widgets,
}

impl Bench {
    fn new() -> Self {
        let context = egui::Context::default();
        context.enable_accesskit();
        let settings = RenderSettings { scene: "cornell".into(), ..Default::default() };
        let mut bench = Self {
            context,
            session: Session::new(settings),
            shown: Shown::default(),
            screen: Screen::default(),
            store: Store::default(),
            actions: Vec::new(),
            widgets: Widgets::default(),
        };
        bench.tell(Event::Knobs(vec![("gather", vec![switch("mips")]), ("five_phase", vec![radius()])]));
        bench.tell(Event::Scene(Box::new(facts())));
        bench.tell(Event::Frame(Box::new(frame(0))));
        bench.idle();
        bench
    }

    fn tell(&mut self, event: Event) {
        self.shown.take(event, &mut self.session);
    }

    fn frame(&mut self, events: Vec<egui::Event>) {
        let screen_rect = Some(Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1440.0, 1600.0)));
        let input = RawInput { screen_rect, events, max_texture_side: Some(8192), ..Default::default() };
        let mut desk = Desk {
            session: &mut self.session,
            shown: &mut self.shown,
            screen: &mut self.screen,
            store: &mut self.store,
            actions: &mut self.actions,
        };
        let full = self.context.clone().run_ui(input, |ui| show(ui, &mut desk));
        self.widgets = Widgets::of(full.platform_output.accesskit_update.as_ref());
        full.drop_without_applying_deltas();
    }

    fn idle(&mut self) {
        // What opens or closes does so over some frames.
        (0..12).for_each(|_| self.frame(Vec::new()));
    }

    fn place(&self, name: &str) -> egui::Pos2 {
        let found = self.widgets.find(name).map(|widget| widget.rect.center());
        found.unwrap_or_else(|| unreachable!("no {name} among {:?}", self.widgets.names()))
    }

    fn click(&mut self, name: &str) {
        let at = self.place(name);
        self.frame(moved(at));
        self.frame(vec![pressed(at, PointerButton::Primary, true)]);
        self.frame(vec![pressed(at, PointerButton::Primary, false)]);
        self.idle();
    }

    fn drag(&mut self, button: PointerButton, from: egui::Pos2, by: egui::Vec2) {
        self.frame(moved(from));
        self.frame(vec![pressed(from, button, true)]);
        self.frame(moved(from + 0.5 * by));
        self.frame(moved(from + by));
        self.frame(vec![pressed(from + by, button, false)]);
        self.idle();
    }
}

fn switch(name: &'static str) -> KnobInfo {
    let default = "on".into();
    KnobInfo { name, unit: "", allowed: "on, off".into(), kind: KnobKind::Bool, default, doc: "a switch" }
}

fn radius() -> KnobInfo {
    let (allowed, kind) = ("0..=32".into(), KnobKind::Int(0, 32));
    KnobInfo { name: "k0", unit: "px", allowed, kind, default: "2".into(), doc: "half width" }
}

fn facts() -> SceneFacts {
    let (Some(build), settings) = (scene::built_in::by_name("cornell"), RenderSettings::default()) else {
        unreachable!("it is built in")
    };
    let scene = build();
    SceneFacts {
        settings: RenderSettings { scene: "cornell".into(), ..settings },
        cameras: scene.cameras.clone(),
        bounds: scene.bounds(),
        duration: 0.0,
        has_motion: false,
        sun: None,
        triangle_count: 32,
        warnings: Vec::new(),
    }
}

fn frame(side: usize) -> Frame {
    let pass = |name: &str, ms| Pass { name: name.into(), gpu_ms: Some(ms), runs: 1 };
    Frame {
        side,
        radiance: Arc::new(Image::filled([40, 30], [0.5; 3])),
        number: 3,
        time: 0.0,
        passes: vec![pass("gather/trace", 1.5), pass("trace/voxel/segment", 8.0)],
        counts: Vec::new(),
        memory: Vec::new(),
        wall_ms: 12.0,
    }
}

#[test]
fn every_stage_is_chosen_from_its_list() {
    let mut bench = Bench::new();
    for (kind, id) in [("tracer", "bvh_cwbvh"), ("denoiser", "svgf"), ("upsampler", "nearest")] {
        bench.click(kind);
        bench.click(id);
    }
    let settings = &bench.session.asked.a;
    let chosen = [&settings.tracer, &settings.denoiser, &settings.upsampler];
    assert_eq!(chosen, ["bvh_cwbvh", "svgf", "nearest"]);
    bench.click("undo");
    assert_eq!(bench.session.asked.a.upsampler, "best_candidate");
    bench.click("redo");
    assert_eq!(bench.session.asked.a.upsampler, "nearest");
}

#[test]
fn knobs_turn_and_go_back_and_foreign_ones_leave_with_their_stage() {
    let mut bench = Bench::new();
    bench.click("gather knobs");
    bench.click("mips");
    assert_eq!(bench.session.asked.a.sets_for("gather").collect::<Vec<_>>(), [("mips", "off")]);
    bench.click("reset");
    assert!(bench.session.asked.a.sets.is_empty());
    bench.session.edit(|s| crate::session::set_knob(s, "five_phase", "k0", Some("5".into())));
    bench.click("denoiser");
    bench.click("identity");
    assert!(bench.session.asked.a.sets.is_empty(), "a stage that is gone has no knobs to set");
}

#[test]
fn the_copied_line_is_what_is_shown() {
    let mut bench = Bench::new();
    bench.click("tracer");
    bench.click("bvh_lbvh");
    bench.click("copy line");
    let Some(Action::Copy(line)) = bench.actions.pop() else { unreachable!("{:?}", bench.actions) };
    let expected = RenderSettings { frames: 3, ..bench.session.asked.a.clone() };
    assert_eq!(
        line.parse::<RenderLine>().map(|line| line.settings),
        Ok(expected),
        "up to the frame that is shown, the third"
    );
}

#[test]
fn a_split_is_edited_side_by_side_and_its_divider_is_dragged() {
    let mut bench = Bench::new();
    bench.click("compare");
    bench.click("split");
    assert_eq!((bench.session.compare, bench.session.order().sides.len()), (Compare::Split, 2));
    bench.tell(Event::Frame(Box::new(frame(1))));
    bench.idle();
    bench.click("B");
    bench.click("tracer");
    bench.click("bvh_cwbvh");
    let order = bench.session.order();
    assert_eq!((order.sides[0].tracer.as_str(), order.sides[1].tracer.as_str()), ("voxel", "bvh_cwbvh"));
    let middle = bench.place("picture");
    bench.drag(PointerButton::Primary, middle, egui::vec2(-100.0, 0.0));
    assert!(bench.session.divider < 0.5 && bench.session.divider > 0.0, "{}", bench.session.divider);
    assert_eq!(bench.session.edited, Side::B);
}

#[test]
fn hovering_a_pass_shows_its_output_and_a_click_holds_it() {
    let mut bench = Bench::new();
    let at = bench.place("gather/trace");
    bench.frame(moved(at));
    bench.frame(Vec::new());
    assert_eq!(bench.session.watched(), Some("gather/trace"));
    bench.click("trace/voxel/segment");
    bench.frame(moved(egui::Pos2::new(5.0, 5.0)));
    bench.idle();
    assert_eq!(bench.session.order().watched.as_deref(), Some("trace/voxel/segment"));
    bench.click("back to the picture");
    bench.frame(moved(egui::Pos2::new(5.0, 5.0)));
    bench.idle();
    assert_eq!(bench.session.watched(), None);
}

#[test]
fn a_click_inspects_and_the_right_button_turns_the_camera() {
    let mut bench = Bench::new();
    let before = bench.session.asked.a.view.clone();
    bench.click("picture");
    assert_eq!(bench.session.inspected, Some([0.5; 2]));
    assert_eq!(bench.session.asked.a.view, before);
    let middle = bench.place("picture");
    bench.drag(PointerButton::Secondary, middle, egui::vec2(60.0, 0.0));
    assert_ne!(bench.session.asked.a.view, before);
    assert!(!bench.session.order().is_moving, "the button is up");
    bench.click("undo");
    assert_eq!(bench.session.asked.a.view, before);
}

#[test]
fn a_file_is_opened_by_its_ending() {
    let mut bench = Bench::new();
    assert!(bench.session.open_file("notes.txt".as_ref()).is_err());
    assert_eq!(bench.session.open_file("noon.HDR".as_ref()), Ok(()));
    assert!(bench.session.asked.a.sky.is_some());
    assert_eq!(bench.session.open_file("house.glb".as_ref()), Ok(()));
    assert_eq!((bench.session.asked.a.scene.as_str(), &bench.session.asked.a.sky), ("house.glb", &None));
}
