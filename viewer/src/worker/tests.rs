//! The worker without a window: orders in, events out.

use super::*;
use frame::cpu::Image;
use gridlight::settings::{KnobSetting, View};
use std::path::Path;
use std::time::{Duration, Instant};

/// Longer than anything here takes on a busy machine; a worker that hangs fails here.
const PATIENCE: Duration = Duration::from_secs(240);

fn small() -> RenderSettings {
    RenderSettings {
        scene: "cornell".into(),
        view: View::Camera(0),
        trace_size: [24, 18],
        display_size: [48, 36],
        grid: 32,
        spp: 1,
        ..Default::default()
    }
}

fn order(sides: Vec<RenderSettings>) -> Order {
    Order {
        sides,
        is_moving: false,
        is_playing: false,
        frames_at_rest: 1,
        restarts: 0,
        watched: None,
        watched_side: 0,
        inspected: None,
        is_judging: false,
        wants_flip: false,
    }
}

struct Bench {
    worker: Worker,
    order: Order,
}

impl Bench {
    /// None where there is no adapter.
    fn new() -> Option<Self> {
        Self::following(None)
    }

    /// The same, with shaders followed.
    fn following(shaders: Option<&Path>) -> Option<Self> {
        if let Err(e) = frame::Gpu::new(None) {
            assert!(std::env::var_os("GRIDLIGHT_REQUIRE_ADAPTER").is_none(), "{e}");
            println!("skipped: {e}");
            return None;
        }
        let worker = Worker::start(None, shaders, Box::new(|| {})).unwrap();
        Some(Self { worker, order: order(vec![small()]) })
    }

    /// Sends the order, and gives all events until its work is done.
    fn done(&mut self) -> Vec<Event> {
        let number = self.worker.order(self.order.clone()).unwrap();
        self.until(|event| matches!(event, Event::Rests(done) if *done == number))
    }

    fn until(&mut self, is_last: impl Fn(&Event) -> bool) -> Vec<Event> {
        let begun = Instant::now();
        let mut events = Vec::new();
        loop {
            assert!(begun.elapsed() < PATIENCE && !self.worker.is_gone());
            match self.worker.event() {
                Some(event) => {
                    let ends = is_last(&event);
                    events.push(event);
                    if ends {
                        return events;
                    }
                }
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        }
    }

    /// The last picture of each side.
    fn pictures(&mut self) -> [Option<Image<[f32; 3]>>; 2] {
        let mut pictures = [None, None];
        for event in self.done() {
            if let Event::Frame(frame) = event {
                pictures[frame.side] = Some((*frame.radiance).clone());
            }
        }
        pictures
    }
}

fn failures(events: &[Event]) -> Vec<&str> {
    let failed = events.iter().map(|event| match event {
        Event::Failed(why, _) => Some(why.as_str()),
        _ => None,
    });
    failed.flatten().collect()
}

#[test]
fn swaps_and_turned_knobs_give_what_a_fresh_start_gives() {
    let Some(mut bench) = Bench::new() else { return };
    let [plain, _] = bench.pictures();
    let turned = KnobSetting { id: "tracer".into(), knob: "next_event".into(), value: "off".into() };
    let coarse = KnobSetting { id: "five_phase".into(), knob: "k0".into(), value: "8".into() };
    let changes: [fn(&mut RenderSettings); 3] =
        [|s| s.denoiser = "identity".into(), |s| s.tracer = "bvh_cwbvh".into(), |s| s.grid = 16];
    for change in changes {
        change(&mut bench.order.sides[0]);
        assert!(bench.done().iter().any(|event| matches!(event, Event::Frame(_))));
    }
    bench.order.sides[0] = RenderSettings { sets: vec![turned, coarse], ..small() };
    let [walked, _] = bench.pictures();
    let mut fresh = Bench::new().unwrap();
    fresh.order = bench.order.clone();
    assert_eq!(walked, fresh.pictures()[0], "to the bit");
    assert_ne!(walked, plain);
    bench.order.sides[0] = small();
    assert_eq!(bench.pictures()[0], plain, "knobs go back to their defaults");
}

#[test]
fn two_sides_are_two_renders_over_one_world() {
    let Some(mut bench) = Bench::new() else { return };
    let other =
        RenderSettings { denoiser: "identity".into(), upsampler: "nearest".into(), seed: 7, ..small() };
    let [alone, _] = bench.pictures();
    bench.order.sides[0] = other.clone();
    let [other_alone, _] = bench.pictures();
    bench.order = order(vec![small(), other]);
    bench.order.frames_at_rest = 1;
    let events = bench.done();
    let passes = events.iter().filter_map(|event| match event {
        Event::Frame(frame) => {
            Some(frame.passes.iter().filter(|pass| pass.name.starts_with("voxel/")).count())
        }
        _ => None,
    });
    assert_eq!(passes.collect::<Vec<_>>(), [0, 0], "the grid stands already");
    bench.order.restarts += 1;
    assert_eq!(bench.pictures(), [alone, other_alone], "to the bit");
}

#[test]
fn what_cannot_be_had_is_said_and_the_rest_goes_on() {
    let Some(mut bench) = Bench::new() else { return };
    let [before, _] = bench.pictures();
    let wrong: [fn(&mut RenderSettings); 3] = [
        |s| s.scene = "no_such_file.glb".into(),
        |s| s.view = View::Camera(9),
        |s| s.sets = vec![KnobSetting { id: "tracer".into(), knob: "speed".into(), value: "9".into() }],
    ];
    for change in wrong {
        change(&mut bench.order.sides[0]);
        let events = bench.done();
        assert_eq!(failures(&events).len(), 1);
        let standing = events.iter().find_map(|event| match event {
            Event::Failed(_, Some(standing)) => Some(standing.clone()),
            _ => None,
        });
        assert_eq!(standing, Some(vec![small()]));
        bench.order.sides[0] = small();
    }
    bench.order.restarts += 1;
    assert_eq!(bench.pictures()[0], before);
}

#[test]
fn a_lost_device_is_opened_again() {
    let Some(mut bench) = Bench::new() else { return };
    let [before, _] = bench.pictures();
    bench.worker.lose_device();
    bench.order.restarts += 1;
    let events = bench.done();
    assert!(!failures(&events).is_empty());
    let after = events.into_iter().rev().find_map(|event| match event {
        Event::Frame(frame) => Some((*frame.radiance).clone()),
        _ => None,
    });
    assert_eq!(after, before);
}

#[test]
fn an_edited_shader_is_seen_and_a_broken_one_is_told() {
    let name = "best_candidate.wgsl";
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../upsample/src/best_candidate").join(name);
    let built = std::fs::read_to_string(built).unwrap();
    let folder = std::env::temp_dir().join(format!("gridlight-shaders-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("src")).unwrap();
    let file = folder.join("src").join(name);
    std::fs::write(&file, &built).unwrap();
    if let Some(mut bench) = Bench::following(Some(&folder)) {
        let [before, _] = bench.pictures();
        let is_frame = |event: &Event| matches!(event, Event::Frame(_));
        let last = |events: Vec<Event>| match events.into_iter().next_back() {
            Some(Event::Frame(frame)) => Some((*frame.radiance).clone()),
            _ => None,
        };
        let call = "textureStore(out_color, pixel, modulate_pixel";
        assert!(built.contains(call));
        std::fs::write(&file, built.replace(call, "textureStore(out_color, pixel, 0.5 * modulate_pixel"))
            .unwrap();
        let half = last(bench.until(is_frame)).unwrap();
        for (a, b) in before.as_ref().unwrap().texels().iter().zip(half.texels()) {
            // Half a number is exact but for the smallest half floats.
            assert!((0..3).all(|c| (0.5 * a[c] - b[c]).abs() <= 1e-3 * a[c] + 1e-6), "{a:?} {b:?}");
        }
        std::fs::write(&file, built.replace(call, "textureStore(out_color, pixel, no_such_function"))
            .unwrap();
        let events = bench.until(|event| matches!(event, Event::Failed(..)));
        let said = failures(&events)[0];
        assert!(said.contains(name) && said.contains("no_such_function"), "{said}");
        bench.order.restarts += 1;
        assert_eq!(bench.pictures()[0].as_ref(), Some(&half), "the last one that was right stays");
        std::fs::write(&file, &built).unwrap();
        assert_eq!(last(bench.until(is_frame)), before);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn passes_values_and_the_error_are_told() {
    let Some(mut bench) = Bench::new() else { return };
    bench.order.watched = Some("gather/trace/surface".into());
    bench.order.inspected = Some([0.5, 0.5]);
    bench.order.is_judging = true;
    bench.order.sides.push(RenderSettings { denoiser: "identity".into(), ..small() });
    bench.order.wants_flip = true;
    let events = bench.done();
    let output =
        events.iter().find_map(|event| if let Event::Output(output) = event { Some(output) } else { None });
    let texels = output.and_then(|output| output.texels.as_ref()).unwrap();
    assert_eq!(texels.size(), [24, 18]);
    // The back wall's base colour is that of the measured box: white paint.
    let [red, green, blue] = texels.get(12, 9).unwrap();
    assert!(red > green && green > blue && blue > 0.6 && red < 0.9, "{red} {green} {blue}");
    let values =
        events.iter().rev().find_map(|event| if let Event::Values(v) = event { Some(v) } else { None });
    let distance = values.unwrap().iter().find(|(name, _)| name == "trace distance").unwrap();
    assert!(distance.1.ends_with(" m"), "{distance:?}");
    assert!(
        events
            .iter()
            .any(|event| matches!(event, Event::Flip(map, mean) if map.size() == [48, 36] && *mean > 0.0))
    );
    let judged = bench.until(|event| matches!(event, Event::Judged(judgement) if judgement.spp >= 8));
    let Some(Event::Judged(judgement)) = judged.last() else { unreachable!("it is the last") };
    let [filtered, noisy] = judgement.rel_mse[..] else { unreachable!("two sides") };
    assert!(filtered.unwrap() < noisy.unwrap(), "a filter lowers the error: {filtered:?} {noisy:?}");
}
