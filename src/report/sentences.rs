//! The answers in words, for the page and for a pull request.

use super::{Answers, EqualError, EqualTime, Race, Reference, VoxelPrice};

/// Sentences in the order a reader asks: how fast, at what error, was it worth it, what do voxels cost.
pub fn of(answers: &Answers) -> Vec<String> {
    let mut all = Vec::new();
    if answers.judged_against == Reference::Voxel {
        all.push("No row was measured against triangles: errors here leave out what voxels cost.".to_owned());
    }
    all.extend(headline(&answers.races).map(race));
    all.extend(answers.equal_error.as_ref().and_then(equal_error));
    // The largest advantage and the smallest.
    let ratio = |e: &&EqualTime| e.error_ratio;
    all.extend(extremes(&answers.equal_times, ratio).into_iter().map(equal_time));
    all.extend(prices(&answers.prices));
    if let Some((first, last)) = answers.pareto.first().zip(answers.pareto.last()) {
        all.push(match answers.pareto.len() {
            1 => format!("{} beats every other in both time and error.", first.configuration),
            n => format!(
                "{n} configurations lie on the Pareto front, from {} ({}, relMSE {}) to {} ({}, relMSE {}).",
                first.configuration,
                ms(first.total_ms),
                significant(first.rel_mse),
                last.configuration,
                ms(last.total_ms),
                significant(last.rel_mse),
            ),
        });
    }
    all
}

/// The race with the widest ratio and the one with the narrowest: the claim and its weakest case.
fn headline(races: &[Race]) -> impl Iterator<Item = &Race> {
    let ratio = |race: &&Race| race.entrants.last().map_or(1.0, |e| e.times_as_long);
    extremes(races, ratio).into_iter()
}

/// The entries with the largest and the smallest value; one where they are the same.
fn extremes<T>(all: &[T], value: impl Fn(&&T) -> f64) -> Vec<&T> {
    let order = |a: &&T, b: &&T| value(a).total_cmp(&value(b));
    let (largest, smallest) = (all.iter().max_by(order), all.iter().min_by(order));
    let second = smallest.filter(|s| !largest.is_some_and(|l| std::ptr::eq(*s, l)));
    largest.into_iter().chain(second).collect()
}

fn race(race: &Race) -> String {
    let Race { denoiser, upsampler, spp, knobs, entrants } = race;
    let knobs = knobs.iter().fold(String::new(), |words, (knob, value)| words + &format!(", {knob}={value}"));
    let [first, others @ ..] = &entrants[..] else { return String::new() };
    let error = |value: Option<f64>| value.map_or("not measured".into(), significant);
    let others: Vec<String> = others
        .iter()
        .map(|e| {
            format!(
                "{} as fast as {} ({}; relMSE {})",
                times(e.times_as_long),
                e.tracer,
                ms(e.total_ms),
                error(e.rel_mse_bvh.or(e.rel_mse_voxel)),
            )
        })
        .collect();
    format!(
        "With {denoiser} and {upsampler} at {spp} spp{knobs}, {} is the fastest: {} a frame at relMSE {}, {}.",
        first.tracer,
        ms(first.total_ms),
        error(first.rel_mse_bvh.or(first.rel_mse_voxel)),
        others.join(", "),
    )
}

fn equal_error(answer: &EqualError) -> Option<String> {
    let mut timed = answer.curves.iter().filter_map(|c| Some((c, c.total_ms?)));
    let (first, fastest) = timed.next()?;
    let time = |at_most: bool, total_ms| format!("{}{}", if at_most { "at most " } else { "" }, ms(total_ms));
    let mut text = format!(
        "To reach relMSE {}, {} takes {}",
        significant(answer.rel_mse),
        first.curve,
        time(first.at_most, fastest)
    );
    if let Some((second, total_ms)) = timed.next() {
        let ratio = if second.at_most || first.at_most {
            String::new()
        } else {
            format!(", {} as long", times(total_ms / fastest))
        };
        text += &format!("; next is {} with {}{ratio}", second.curve, time(second.at_most, total_ms));
    }
    let never = answer.curves.iter().filter(|c| c.total_ms.is_none()).count();
    if never > 0 {
        text += &format!("; {never} of {} never get there", answer.curves.len());
    }
    Some(text + ".")
}

fn equal_time(answer: &EqualTime) -> String {
    let EqualTime { point, plain, error_ratio } = answer;
    let verdict = match *error_ratio >= 1.0 {
        true => format!("{} the error", times(*error_ratio)),
        false => format!("only {} of the error", percent(*error_ratio)),
    };
    format!(
        "In the time of {} ({}, relMSE {}), plain path tracing ({}) gets to relMSE {}: {verdict}.",
        point.configuration,
        ms(point.total_ms),
        significant(point.rel_mse),
        plain.configuration,
        significant(plain.rel_mse),
    )
}

fn prices(prices: &[VoxelPrice]) -> Option<String> {
    let order = |a: &&VoxelPrice, b: &&VoxelPrice| a.share.total_cmp(&b.share);
    let (low, high) = (prices.iter().min_by(order)?, prices.iter().max_by(order)?);
    let of = |p: &VoxelPrice| format!("{} of the squared error of {}", percent(p.share), p.configuration);
    Some(match prices.len() {
        1 => format!("The price of voxels, their gap to triangles, is {}.", of(low)),
        _ => {
            format!("The price of voxels, their gap to triangles, goes from {} to {}.", of(low), of(high))
        }
    })
}

/// Three significant digits, as people write them.
pub fn significant(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || !v.is_finite() => value.to_string(),
        v if !(1e-4..1e5).contains(&v) => format!("{value:.2e}"),
        v => format!("{value:.*}", (2 - v.log10().floor() as i32).max(0) as usize),
    }
}

/// Milliseconds with their unit.
fn ms(value: f64) -> String {
    format!("{} ms", significant(value))
}

/// A ratio: `2.36 times`.
fn times(ratio: f64) -> String {
    format!("{} times", significant(ratio))
}

/// A share, without decimals.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", share * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::synthetic::measured_row;

    #[test]
    fn three_digits() {
        let texts = [0.0, 0.012345, 1.0, 12.345, 123.456, 12345.6, 1e-5, 2.5e7].map(significant);
        assert_eq!(texts, ["0", "0.0123", "1.00", "12.3", "123", "12346", "1.00e-5", "2.50e7"]);
    }

    #[test]
    fn a_race_is_told_with_its_ratio_and_errors() {
        let rows = [
            measured_row("voxel", "svgf", 4, Reference::Bvh, 10.0, 0.02),
            measured_row("bvh_cwbvh", "svgf", 4, Reference::Bvh, 23.6, 0.012),
        ];
        let told = of(&Answers::of(&rows, &[]));
        assert_eq!(
            told[0],
            "With svgf and best_candidate at 4 spp, voxel (grid 256) is the fastest: 10.0 ms a frame at relMSE 0.0200, \
             2.36 times as fast as bvh_cwbvh (23.6 ms; relMSE 0.0120)."
        );
    }

    #[test]
    fn nothing_measured_is_nothing_said() {
        assert_eq!(of(&Answers::default()), [""; 0]);
    }
}
