//! Live error: how far the picture is from the reference that converges while the view rests.

use super::Desk;
use crate::session::Side;
use egui::Ui;
use egui_plot::{Legend, Line, Plot, PlotPoints};

/// Points.
const PLOT_HEIGHT: f32 = 110.0;

/// The right panel's part about error.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    egui::CollapsingHeader::new("error").default_open(true).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.checkbox(&mut desk.session.judging, "live error").on_hover_text(
                "While the view rests, paths through the triangles converge to its true image",
            );
            ui.checkbox(&mut desk.session.error_map, "error map")
                .on_hover_text("Relative squared error of each pixel; the brightest colour is 0.25 or more");
        });
        let Some(judgement) = &desk.shown.judgement else {
            ui.weak(if desk.session.judging { "once the view rests" } else { "off" });
            return;
        };
        for (side, error) in [Side::A, Side::B].into_iter().zip(&judgement.rel_mse) {
            let frame = desk.shown.frames[side.index()].as_ref();
            let gpu_ms: Option<f64> = frame.and_then(|f| f.passes.iter().map(|p| p.gpu_ms).sum());
            let error = error.map_or("not a number".into(), |error| format!("{error:.5}"));
            let ms = gpu_ms.map_or(String::new(), |ms| format!(" at {ms:.1} ms"));
            ui.label(format!("{}: relMSE {error}{ms}", side.name()));
        }
        ui.weak(format!(
            "reference: {} samples in {:.0} s, its own noise {:.5}",
            judgement.spp, judgement.seconds, judgement.noise_rel_mse
        ));
        Plot::new("error curve")
            .height(PLOT_HEIGHT)
            .include_y(0.0)
            .legend(Legend::default())
            .x_axis_label("samples of the reference")
            .allow_scroll(false)
            .show(ui, |plot| {
                for side in [Side::A, Side::B] {
                    let points: PlotPoints = desk.shown.curves[side.index()].iter().copied().collect();
                    plot.line(Line::new(format!("relMSE of {}", side.name()), points));
                }
            });
    });
}
