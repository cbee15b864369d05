//! The picture: one or two sides, a pass's output or a map in its place, and the hand that moves the camera.

use super::Desk;
use crate::picture;
use crate::session::camera::{approach, look_around, orbit, walk};
use crate::session::{Compare, Development, Side};
use crate::worker::SceneFacts;
use egui::{
    Color32, ColorImage, Key, PointerButton, Pos2, Rect, Response, Sense, TextureHandle, TextureOptions, Ui,
};
use glam::Vec3;
use std::collections::HashMap;

/// Radians a point of dragging turns.
const TURN_PER_POINT: f32 = 0.005;

/// Points beside the divider that still take hold of it.
const GRIP: f32 = 8.0;

/// Relative squared error that the map shows in its brightest colour.
const FULL_ERROR: f32 = 0.25;

/// Seconds each side is seen in turn.
const FLICKER_SECONDS: f64 = 0.5;

/// What can be on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Slot {
    Side(usize),
    Output,
    ErrorMap,
    Difference,
    Flip,
}

/// Pictures as the graphics card has them, made anew when their numbers or their development change.
#[derive(Default)]
pub struct Screen {
    slots: HashMap<Slot, (TextureHandle, (u64, Development))>,
    holds_divider: bool,
}

impl Screen {
    fn texture(
        &mut self,
        ui: &Ui,
        slot: Slot,
        stamp: (u64, Development),
        make: impl FnOnce() -> Option<ColorImage>,
    ) -> Option<TextureHandle> {
        if let Some((texture, made)) = self.slots.get(&slot)
            && *made == stamp
        {
            return Some(texture.clone());
        }
        let image = make()?;
        // Wider than the window's card can: nothing rather than an end.
        let most = ui.ctx().input(|i| i.max_texture_side);
        if image.size.iter().any(|side| *side > most) {
            return None;
        }
        match self.slots.get_mut(&slot) {
            Some((texture, made)) => {
                texture.set(image, TextureOptions::NEAREST);
                *made = stamp;
                Some(texture.clone())
            }
            None => {
                let texture = ui.ctx().load_texture(format!("{slot:?}"), image, TextureOptions::NEAREST);
                self.slots.insert(slot, (texture.clone(), stamp));
                Some(texture)
            }
        }
    }
}

/// The middle of the window.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    let (whole, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "picture"));
    ui.painter().rect_filled(whole, 0.0, Color32::BLACK);
    let Some(rect) = paint(ui, whole, desk) else {
        let words = desk.shown.progress.as_ref().map_or("no picture yet", |(what, _)| what.as_str());
        let font = egui::TextStyle::Heading.resolve(ui.style());
        ui.painter().text(whole.center(), egui::Align2::CENTER_CENTER, words, font, Color32::GRAY);
        return;
    };
    divide(ui, rect, &response, desk);
    inspect(ui, rect, &response, desk);
    if let Some(facts) = desk.shown.scene.clone() {
        navigate(ui, &response, &facts, desk);
    }
}

/// The largest rectangle of the picture's aspect in the middle of another.
fn fitted(whole: Rect, [width, height]: [usize; 2]) -> Rect {
    let zoom = (whole.width() / width.max(1) as f32).min(whole.height() / height.max(1) as f32);
    Rect::from_center_size(whole.center(), egui::vec2(width as f32, height as f32) * zoom)
}

/// Paints what is to be seen, and says where; none where there is nothing yet.
fn paint(ui: &mut Ui, whole: Rect, desk: &mut Desk<'_>) -> Option<Rect> {
    let (session, shown) = (&*desk.session, &*desk.shown);
    let stamp = (shown.revision, session.development);
    let picture = |side: usize| shown.frames[side].as_ref().map(|frame| &frame.radiance);
    let screen = &mut *desk.screen;
    let side = |screen: &mut Screen, index: usize| {
        let image = picture(index)?;
        screen.texture(ui, Slot::Side(index), stamp, || Some(picture::develop(image, &session.development)))
    };
    let edited = session.edited.index();
    if let (Some(watched), Some(output)) = (session.watched(), &shown.output)
        && output.pass == watched
    {
        let made = || picture::develop_output(output, &session.development);
        if let Some(texture) = screen.texture(ui, Slot::Output, stamp, made) {
            return Some(one(ui, whole, &texture, &output.what));
        }
        let rect = side(screen, edited).map(|texture| one(ui, whole, &texture, &output.what));
        return rect;
    }
    if let (true, Some(map)) = (session.error_map, shown.judgement.as_ref().and_then(|j| j.maps.get(edited)))
    {
        let texture = screen.texture(ui, Slot::ErrorMap, stamp, || Some(picture::heat(map, FULL_ERROR)))?;
        return Some(one(ui, whole, &texture, "relative squared error"));
    }
    let both = picture(0).zip(picture(1)).filter(|_| session.asked.b.is_some());
    match (session.compare, both) {
        (Compare::Split, Some(_)) => {
            let (a, b) = (side(screen, 0)?, side(screen, 1)?);
            let rect = fitted(whole, a.size());
            let x = rect.left() + session.divider * rect.width();
            let [left, right] = [rect.with_max_x(x), rect.with_min_x(x)];
            for (texture, clip) in [(&a, left), (&b, right)] {
                ui.painter().with_clip_rect(clip).image(texture.id(), rect, UV, Color32::WHITE);
            }
            ui.painter().vline(x, rect.y_range(), (1.5, Color32::WHITE));
            caption(ui, rect.left_top(), "A", egui::Align2::LEFT_TOP);
            caption(ui, rect.right_top(), "B", egui::Align2::RIGHT_TOP);
            Some(rect)
        }
        (Compare::Flicker, Some(_)) => {
            let time = ui.input(|i| i.time);
            let turn = (time / FLICKER_SECONDS) as u64 % 2;
            let left = FLICKER_SECONDS - time % FLICKER_SECONDS;
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
            let index = turn as usize;
            let texture = side(screen, index)?;
            Some(one(ui, whole, &texture, if index == 0 { "A" } else { "B" }))
        }
        (Compare::Difference, Some((a, b))) => {
            let development = session.development;
            let made = || Some(picture::develop(&picture::difference(a, b), &development));
            let texture = screen.texture(ui, Slot::Difference, stamp, made)?;
            Some(one(ui, whole, &texture, "difference"))
        }
        (Compare::Flip, Some(_)) if shown.flip.is_some() => {
            let (map, _) = shown.flip.as_ref()?;
            let texture = screen.texture(ui, Slot::Flip, stamp, || Some(picture::heat(map, 1.0)))?;
            Some(one(ui, whole, &texture, "FLIP of B against A"))
        }
        _ => {
            let texture = side(screen, if both.is_some() { edited } else { 0 })?;
            Some(one(ui, whole, &texture, ""))
        }
    }
}

const UV: Rect = Rect { min: Pos2::ZERO, max: Pos2::new(1.0, 1.0) };

fn one(ui: &Ui, whole: Rect, texture: &TextureHandle, words: &str) -> Rect {
    let rect = fitted(whole, texture.size());
    ui.painter().image(texture.id(), rect, UV, Color32::WHITE);
    if !words.is_empty() {
        caption(ui, rect.left_top(), words, egui::Align2::LEFT_TOP);
    }
    rect
}

/// Words that can be read on any picture.
fn caption(ui: &Ui, at: Pos2, words: &str, align: egui::Align2) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let galley = ui.painter().layout_no_wrap(words.into(), font, Color32::WHITE);
    let rect = align.anchor_size(at, galley.size() + egui::vec2(8.0, 4.0));
    ui.painter().rect_filled(rect, 2.0, Color32::from_black_alpha(150));
    ui.painter().galley(rect.min + egui::vec2(4.0, 2.0), galley, Color32::WHITE);
}

fn divide(ui: &Ui, rect: Rect, response: &Response, desk: &mut Desk<'_>) {
    if desk.session.compare != Compare::Split || desk.session.asked.b.is_none() {
        desk.screen.holds_divider = false;
        return;
    }
    let x = rect.left() + desk.session.divider * rect.width();
    let pointer = response.hover_pos().or(response.interact_pointer_pos());
    let is_near = |at: Pos2| (at.x - x).abs() <= GRIP;
    if pointer.is_some_and(is_near) || desk.screen.holds_divider {
        ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
    }
    let pressed_at = ui.input(|i| i.pointer.press_origin());
    if response.drag_started_by(PointerButton::Primary) {
        desk.screen.holds_divider = pressed_at.is_some_and(is_near);
    }
    if !response.dragged_by(PointerButton::Primary) {
        desk.screen.holds_divider = false;
    } else if let (true, Some(at)) = (desk.screen.holds_divider, response.interact_pointer_pos()) {
        desk.session.divider = ((at.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
}

fn inspect(ui: &Ui, rect: Rect, response: &Response, desk: &mut Desk<'_>) {
    let place = |at: Pos2| {
        let share = (at - rect.min) / rect.size();
        [share.x, share.y].map(|v| v.clamp(0.0, 1.0))
    };
    if response.clicked_by(PointerButton::Primary)
        && let Some(at) = response.interact_pointer_pos().filter(|at| rect.contains(*at))
    {
        desk.session.inspected = Some(place(at));
        // In a split the side that was clicked.
        if desk.session.compare == Compare::Split && desk.session.asked.b.is_some() {
            let is_b = place(at)[0] > desk.session.divider;
            desk.session.edited = if is_b { Side::B } else { Side::A };
        }
    }
    if let Some([x, y]) = desk.session.inspected {
        let at = rect.min + rect.size() * egui::vec2(x, y);
        let stroke = (1.0, Color32::YELLOW);
        ui.painter().hline(at.x - 6.0..=at.x + 6.0, at.y, stroke);
        ui.painter().vline(at.x, at.y - 6.0..=at.y + 6.0, stroke);
    }
}

fn navigate(ui: &Ui, response: &Response, facts: &SceneFacts, desk: &mut Desk<'_>) {
    let session = &mut *desk.session;
    let turns = response.dragged_by(PointerButton::Secondary);
    let types = ui.ctx().egui_wants_keyboard_input();
    if turns {
        let by = response.drag_delta() * TURN_PER_POINT;
        if by != egui::Vec2::ZERO {
            let orbits = session.flight.orbits;
            session.fly(
                facts,
                |look| if orbits { orbit(look, by.x, by.y) } else { look_around(look, by.x, -by.y) },
            );
        }
    }
    let held = |key: Key| ui.input(|i| i.key_down(key) && !i.modifiers.command);
    let axis = |more: Key, less: Key| f32::from(u8::from(held(more))) - f32::from(u8::from(held(less)));
    let step = Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
    let walks = turns && step != Vec3::ZERO;
    if walks {
        let metres = session.flight.speed(facts.bounds) * ui.input(|i| i.stable_dt.min(0.1));
        session.fly(facts, |look| walk(look, metres * step.normalize()));
    }
    if turns {
        ui.ctx().request_repaint();
    }
    let notches = if response.hovered() { ui.input(|i| i.smooth_scroll_delta().y) / 50.0 } else { 0.0 };
    if notches != 0.0 {
        match session.flight.orbits {
            true => session.fly(facts, |look| approach(look, notches)),
            false => session.flight.faster(facts.bounds, notches),
        }
    }
    if !types && ui.input(|i| i.key_pressed(Key::F) && i.modifiers.is_none()) {
        session.frame(facts);
    }
    session.flight.is_moving = turns;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_fills_its_place_and_keeps_its_aspect() {
        let whole = Rect::from_min_size(Pos2::new(10.0, 20.0), egui::vec2(400.0, 300.0));
        assert_eq!(fitted(whole, [40, 30]), whole);
        assert_eq!(fitted(whole, [40, 10]).size(), egui::vec2(400.0, 100.0));
        assert_eq!(fitted(whole, [10, 40]).center(), whole.center());
    }
}
