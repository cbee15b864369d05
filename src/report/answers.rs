//! What the rows say: who is fastest, at what error, what voxels cost, what is worth its time.
//!
//! Times are medians of whole frames in ms, errors are relMSE. Where not said otherwise an error is the true one, against
//! triangles; a comparison that has no such rows is judged against voxels, and says so. Questions that the rows cannot
//! answer (no times, a single tracer) stay empty.

use super::{Errors, Reference, ReferenceInfo, Row};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that is answered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    /// What true error means in these answers.
    pub judged_against: Reference,
    /// One per filter, upsampler, sample count and set of knobs for which at least two tracers were timed.
    pub races: Vec<Race>,
    /// One per configuration that traces voxels and was measured against both references.
    pub prices: Vec<VoxelPrice>,
    /// One per row that plain path tracing was given the time of.
    pub equal_times: Vec<EqualTime>,
    /// How long each curve takes to one error; none without times.
    pub equal_error: Option<EqualError>,
    /// Configurations that no other beats in both time and error, fastest first.
    pub pareto: Vec<Point>,
}

/// Tracers that did the same work with all else equal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Race {
    /// Id of the denoiser.
    pub denoiser: String,
    /// Id of the upsampler.
    pub upsampler: String,
    /// Paths per trace pixel.
    pub spp: u32,
    /// Knobs set on top of the preset.
    pub knobs: BTreeMap<String, String>,
    /// At least two, fastest first.
    pub entrants: Vec<Entrant>,
}

/// A tracer in a race.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entrant {
    /// Id, and grid where it has one.
    pub tracer: String,
    /// Median of the whole frame.
    pub total_ms: f64,
    /// Its time over the winner's.
    pub times_as_long: f64,
    /// relMSE against converged triangles.
    pub rel_mse_bvh: Option<f64>,
    /// relMSE against converged voxels.
    pub rel_mse_voxel: Option<f64>,
}

/// How much of a configuration's error is that it traces voxels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VoxelPrice {
    /// The configuration.
    pub configuration: String,
    /// Squared error against triangles: all there is.
    pub total_mse: f64,
    /// Squared error against voxels: sampling and filtering.
    pub own_mse: f64,
    /// The gap between the references over `total_mse`. The gap is the references' own difference where it was measured,
    /// otherwise `total_mse - own_mse` (the parts add up as squares when they are uncorrelated). Above 1 a blur hides
    /// part of the gap; below 0 voxels and blur cancel.
    pub share: f64,
}

/// A configuration beside plain path tracing of the same time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EqualTime {
    /// The configuration, with its time and error.
    pub point: Point,
    /// Plain path tracing, with its own.
    pub plain: Point,
    /// Plain path tracing's error over the configuration's.
    pub error_ratio: f64,
}

/// A configuration in the plane of error against time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// [`Row::configuration`].
    pub configuration: String,
    /// Median of the whole frame.
    pub total_ms: f64,
    /// The true error.
    pub rel_mse: f64,
}

/// Times to one error, which at least half of the curves reach (both of two).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EqualError {
    /// That error.
    pub rel_mse: f64,
    /// Fastest first, those that never get there last.
    pub curves: Vec<TimeToError>,
}

/// When a curve (all sample counts of one configuration) reaches the error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeToError {
    /// [`Row::curve`].
    pub curve: String,
    /// Straight between two measured points on log axes; none where it does not get there.
    pub total_ms: Option<f64>,
    /// Its cheapest point is better already: the time is a bound from above.
    pub at_most: bool,
}

/// A configuration with its errors against each reference.
struct Measured<'a> {
    row: &'a Row,
    bvh: Option<&'a Errors>,
    voxel: Option<&'a Errors>,
}

impl Measured<'_> {
    fn rel_mse(&self, reference: Reference) -> Option<f64> {
        let errors = match reference {
            Reference::Bvh => self.bvh,
            Reference::Voxel => self.voxel,
        };
        errors?.rel_mse
    }

    fn point(&self, reference: Reference) -> Option<Point> {
        Some(Point {
            configuration: self.row.configuration(),
            total_ms: self.row.median_ms()?,
            rel_mse: self.rel_mse(reference)?,
        })
    }
}

impl Answers {
    /// Reads the answers off the rows of one scene.
    pub fn of(rows: &[Row], references: &[ReferenceInfo]) -> Self {
        let measured = measured(rows);
        let judge = match measured.iter().any(|m| m.bvh.is_some()) || measured.is_empty() {
            true => Reference::Bvh,
            false => Reference::Voxel,
        };
        Self {
            judged_against: judge,
            races: races(&measured),
            prices: measured.iter().filter_map(|m| price(m, references)).collect(),
            equal_times: measured.iter().filter_map(|m| equal_time(m, &measured, judge)).collect(),
            equal_error: equal_error(&measured, judge),
            pareto: pareto(&measured, judge),
        }
    }
}

/// Rows that differ in the reference only become one.
fn measured(rows: &[Row]) -> Vec<Measured<'_>> {
    let mut all: BTreeMap<(String, Option<&str>), Measured<'_>> = BTreeMap::new();
    for row in rows {
        let key = (row.configuration(), row.equal_time.as_deref());
        let one = all.entry(key).or_insert(Measured { row, bvh: None, voxel: None });
        match row.reference {
            Reference::Bvh => one.bvh = Some(&row.errors),
            Reference::Voxel => one.voxel = Some(&row.errors),
        }
    }
    all.into_values().collect()
}

fn races(measured: &[Measured]) -> Vec<Race> {
    let mut races: BTreeMap<_, Vec<Entrant>> = BTreeMap::new();
    for m in measured.iter().filter(|m| m.row.equal_time.is_none()) {
        let Some(total_ms) = m.row.median_ms().filter(|ms| *ms > 0.0) else { continue };
        let row = m.row;
        races.entry((&row.denoiser, &row.upsampler, row.spp, &row.knobs)).or_default().push(Entrant {
            tracer: row.tracer_and_grid(),
            total_ms,
            times_as_long: 1.0,
            rel_mse_bvh: m.rel_mse(Reference::Bvh),
            rel_mse_voxel: m.rel_mse(Reference::Voxel),
        });
    }
    let mut all = Vec::new();
    for ((denoiser, upsampler, spp, knobs), mut entrants) in races {
        sort_by_time(&mut entrants, |e| e.total_ms);
        let [first, _, ..] = &entrants[..] else { continue };
        let fastest = first.total_ms;
        entrants.iter_mut().for_each(|e| e.times_as_long = e.total_ms / fastest);
        let (denoiser, upsampler) = (denoiser.clone(), upsampler.clone());
        all.push(Race { denoiser, upsampler, spp, knobs: knobs.clone(), entrants });
    }
    all
}

fn price(m: &Measured, references: &[ReferenceInfo]) -> Option<VoxelPrice> {
    let row = m.row;
    let total_mse = m.bvh?.rmse?.powi(2);
    let own_mse = m.voxel?.rmse?.powi(2);
    if !row.traces_voxels() || total_mse <= 0.0 {
        return None;
    }
    let reference = references.iter().find(|r| r.kind == Reference::Voxel && r.grid == row.grid);
    let gap_mse = match reference.and_then(|r| r.gap_rmse) {
        Some(gap_rmse) => gap_rmse.powi(2),
        None => total_mse - own_mse,
    };
    Some(VoxelPrice { configuration: row.configuration(), total_mse, own_mse, share: gap_mse / total_mse })
}

fn equal_time(m: &Measured, all: &[Measured], judge: Reference) -> Option<EqualTime> {
    let other = m.row.equal_time.as_deref()?;
    let matched = all.iter().find(|o| o.row.equal_time.is_none() && o.row.configuration() == other)?;
    let (point, plain) = (matched.point(judge)?, m.point(judge)?);
    let error_ratio = Some(plain.rel_mse / point.rel_mse).filter(|ratio| ratio.is_finite())?;
    Some(EqualTime { point, plain, error_ratio })
}

fn equal_error(measured: &[Measured], judge: Reference) -> Option<EqualError> {
    let mut curves: BTreeMap<String, Vec<Point>> = BTreeMap::new();
    for m in measured {
        // Zero has no place on a log axis, and nobody measures it.
        if let Some(point) = m.point(judge).filter(|p| p.total_ms > 0.0 && p.rel_mse > 0.0) {
            curves.entry(m.row.curve()).or_default().push(point);
        }
    }
    curves.values_mut().for_each(|points| sort_by_time(points, |p| p.total_ms));
    let best = |points: &Vec<Point>| points.iter().map(|p| p.rel_mse).fold(f64::INFINITY, f64::min);
    let mut bests: Vec<f64> = curves.values().map(best).collect();
    bests.sort_by(f64::total_cmp);
    let rel_mse = *bests.get(bests.len() / 2)?;
    let mut times: Vec<TimeToError> = curves
        .into_iter()
        .map(|(curve, points)| {
            let (total_ms, at_most) = time_to(rel_mse, &points);
            TimeToError { curve, total_ms, at_most }
        })
        .collect();
    sort_by_time(&mut times, |t| t.total_ms.unwrap_or(f64::INFINITY));
    Some(EqualError { rel_mse, curves: times })
}

/// When points, sorted by time, first reach an error, and whether the first of them is there already.
fn time_to(rel_mse: f64, points: &[Point]) -> (Option<f64>, bool) {
    let Some(at) = points.iter().position(|p| p.rel_mse <= rel_mse) else { return (None, false) };
    let before = at.checked_sub(1).and_then(|i| points.get(i));
    match (before, points.get(at)) {
        (Some(a), Some(b)) => {
            let share = (a.rel_mse / rel_mse).ln() / (a.rel_mse / b.rel_mse).ln();
            (Some(a.total_ms * (b.total_ms / a.total_ms).powf(share)), false)
        }
        (None, first) => (first.map(|p| p.total_ms), first.is_some_and(|p| p.rel_mse < rel_mse)),
        (Some(_), None) => (None, false),
    }
}

fn pareto(measured: &[Measured], judge: Reference) -> Vec<Point> {
    let mut points: Vec<Point> = measured.iter().filter_map(|m| m.point(judge)).collect();
    points.sort_by(|a, b| a.total_ms.total_cmp(&b.total_ms).then(a.rel_mse.total_cmp(&b.rel_mse)));
    let mut best = f64::INFINITY;
    points.retain(|p| {
        let better = p.rel_mse < best;
        best = best.min(p.rel_mse);
        better
    });
    points
}

/// Stable, so that equal times keep the order of the names.
fn sort_by_time<T>(all: &mut [T], ms: impl Fn(&T) -> f64) {
    all.sort_by(|a, b| ms(a).total_cmp(&ms(b)));
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;
    use crate::report::synthetic::{measured_row, row, voxel_reference};

    fn close(a: f64, b: f64) -> bool {
        // Rounding of a few operations in f64.
        (a - b).abs() <= 1e-12 * b.abs()
    }

    #[test]
    fn the_fastest_tracer_and_its_ratio() {
        let rows = [
            measured_row("voxel", "svgf", 4, Reference::Bvh, 10.0, 0.02),
            measured_row("voxel", "svgf", 4, Reference::Voxel, 10.0, 0.01),
            measured_row("bvh_cwbvh", "svgf", 4, Reference::Bvh, 25.0, 0.012),
            // Alone at its sample count: no race.
            measured_row("voxel", "svgf", 8, Reference::Bvh, 20.0, 0.01),
        ];
        let races = Answers::of(&rows, &[]).races;
        assert_eq!(races.len(), 1);
        let [first, second] = &races[0].entrants[..] else { panic!("{races:?}") };
        assert_eq!((&*first.tracer, first.total_ms, first.times_as_long), ("voxel (grid 256)", 10.0, 1.0));
        assert_eq!((first.rel_mse_bvh, first.rel_mse_voxel), (Some(0.02), Some(0.01)));
        assert_eq!((&*second.tracer, second.times_as_long, second.rel_mse_voxel), ("bvh_cwbvh", 2.5, None));
    }

    #[test]
    fn the_price_of_voxels_by_difference_and_by_the_measured_gap() {
        let mut rows = [row("voxel", "svgf", 4, Reference::Bvh), row("voxel", "svgf", 4, Reference::Voxel)];
        rows[0].errors.rmse = Some(0.5);
        rows[1].errors.rmse = Some(0.3);
        // (0.25 - 0.09) / 0.25
        assert!(close(Answers::of(&rows, &[]).prices[0].share, 0.64));
        // 0.2^2 / 0.25
        let gap = [voxel_reference(256, 0.2)];
        assert!(close(Answers::of(&rows, &gap).prices[0].share, 0.16));
        // Another grid's gap is not ours; triangles pay nothing.
        assert!(close(Answers::of(&rows, &[voxel_reference(128, 0.2)]).prices[0].share, 0.64));
        rows.iter_mut().for_each(|row| row.tracer = "bvh_lbvh".into());
        assert_eq!(Answers::of(&rows, &gap).prices, []);
    }

    #[test]
    fn time_to_equal_error_is_straight_on_log_axes() {
        let at = |tracer, spp, ms, error| measured_row(tracer, "identity", spp, Reference::Bvh, ms, error);
        // Error falls as 1/t: 0.1 at 10 ms, so 0.04 at 25 ms. The other's best is 0.04, at 80 ms.
        let rows = [
            at("voxel", 1, 10.0, 0.1),
            at("voxel", 8, 80.0, 0.0125),
            at("bvh_lbvh", 1, 20.0, 0.16),
            at("bvh_lbvh", 4, 80.0, 0.04),
            at("bvh_rayquery", 1, 5.0, 0.5),
        ];
        let answer = Answers::of(&rows, &[]).equal_error.unwrap();
        assert_eq!(answer.rel_mse, 0.04);
        let times: Vec<_> =
            answer.curves.iter().map(|c| (c.curve.split(' ').next().unwrap(), c.total_ms)).collect();
        assert_eq!(times[0].0, "voxel");
        assert!(close(times[0].1.unwrap(), 25.0), "{times:?}");
        assert!(close(times[1].1.unwrap(), 80.0), "{times:?}");
        assert_eq!(times[2], ("bvh_rayquery", None));
        // A curve that begins better than the error: a bound.
        let rows = [at("voxel", 1, 10.0, 0.01), at("bvh_lbvh", 1, 20.0, 0.02)];
        let answer = Answers::of(&rows, &[]).equal_error.unwrap();
        assert_eq!((answer.curves[0].total_ms, answer.curves[0].at_most), (Some(10.0), true));
        assert_eq!((answer.curves[1].total_ms, answer.curves[1].at_most), (Some(20.0), false));
    }

    #[test]
    fn equal_time_compares_with_the_row_it_names() {
        let filtered = measured_row("voxel", "five_phase", 4, Reference::Bvh, 12.0, 0.01);
        let mut plain = measured_row("voxel", "identity", 6, Reference::Bvh, 12.1, 0.08);
        plain.equal_time = Some(filtered.configuration());
        let mut lost = measured_row("voxel", "identity", 7, Reference::Bvh, 13.0, 0.07);
        lost.equal_time = Some("nobody".into());
        let answers = Answers::of(&[filtered, plain, lost], &[]);
        assert_eq!(answers.equal_times.len(), 1);
        assert_eq!((answers.equal_times[0].error_ratio, answers.equal_times[0].plain.total_ms), (8.0, 12.1));
        assert_eq!(answers.races, []);
    }

    #[test]
    fn the_pareto_front_leaves_out_what_another_beats() {
        let at = |spp, ms, error| measured_row("voxel", "svgf", spp, Reference::Bvh, ms, error);
        let rows = [at(1, 1.0, 0.5), at(2, 2.0, 0.6), at(3, 3.0, 0.1), at(4, 3.0, 0.2), at(5, 9.0, 0.1)];
        let front: Vec<f64> = Answers::of(&rows, &[]).pareto.iter().map(|p| p.total_ms).collect();
        assert_eq!(front, [1.0, 3.0]);
    }

    #[test]
    fn rows_without_times_or_triangles_answer_what_they_can() {
        let mut row = row("voxel", "svgf", 4, Reference::Voxel);
        row.total_ms = None;
        let answers = Answers::of(&[row], &[]);
        assert_eq!(answers.judged_against, Reference::Voxel);
        assert_eq!((answers.pareto.len(), answers.equal_error, answers.races.len()), (0, None, 0));
        assert_eq!(Answers::of(&[], &[]), Answers::default());
    }
}
