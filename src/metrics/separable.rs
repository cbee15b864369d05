//! Filters that are a row times a column: planes of f32 in and out, the border's value repeated outside.

/// Filters along each row of `width` pixels. An odd number of taps, the middle one on the pixel.
pub(super) fn rows(plane: &[f32], width: usize, taps: &[f32]) -> Vec<f32> {
    let radius = taps.len() / 2;
    let mut out = Vec::with_capacity(plane.len());
    let mut padded = Vec::with_capacity(width + 2 * radius);
    for row in plane.chunks_exact(width) {
        padded.clear();
        padded.resize(radius, row[0]);
        padded.extend_from_slice(row);
        padded.resize(width + 2 * radius, row[width - 1]);
        let sums =
            padded.windows(taps.len()).map(|window| window.iter().zip(taps).map(|(v, w)| v * w).sum::<f32>());
        out.extend(sums);
    }
    out
}

/// Filters along each column; as [`rows`].
pub(super) fn columns(plane: &[f32], width: usize, taps: &[f32]) -> Vec<f32> {
    let radius = taps.len() / 2;
    let height = plane.len() / width;
    let mut out = vec![0.0; plane.len()];
    // Row by row of the source, which stays in the cache.
    for (y, row) in out.chunks_exact_mut(width).enumerate() {
        for (index, weight) in taps.iter().enumerate() {
            let source = (y + index).saturating_sub(radius).min(height - 1) * width;
            for (sum, value) in row.iter_mut().zip(&plane[source..source + width]) {
                *sum += weight * value;
            }
        }
    }
    out
}

/// A filter that is the same along both axes.
pub(super) fn both(plane: &[f32], width: usize, taps: &[f32]) -> Vec<f32> {
    columns(&rows(plane, width, taps), width, taps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_the_filter_and_borders_are_repeated() {
        let taps = [1.0, 2.0, 4.0];
        let mut plane = vec![0.0; 15];
        plane[7] = 1.0;
        // Correlation: the pixel to the left of the point meets it with its last tap.
        assert_eq!(rows(&plane, 5, &taps)[5..10], [0.0, 4.0, 2.0, 1.0, 0.0]);
        let down = columns(&plane, 5, &taps);
        assert_eq!([down[2], down[7], down[12]], [4.0, 2.0, 1.0]);
        assert_eq!(rows(&[1.0, 10.0], 2, &taps), [1.0 + 2.0 + 40.0, 1.0 + 20.0 + 40.0]);
        assert_eq!(columns(&[1.0, 10.0], 1, &taps), [43.0, 61.0]);
    }

    #[test]
    fn a_constant_stays_when_weights_sum_to_one_even_if_the_filter_is_larger() {
        assert_eq!(both(&[3.0; 4], 2, &[0.125, 0.25, 0.25, 0.25, 0.125]), [3.0; 4]);
    }
}
