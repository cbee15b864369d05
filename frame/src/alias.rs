//! Draws one of many in proportion to weights: alias tables (Walker 1977), built as by Vose 1991.

/// Two random numbers and two look-ups choose an entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Alias {
    /// Per entry: whom it stands for else, and the share of the time it stands for itself.
    pub entries: Vec<(u32, f32)>,
    /// Sum of all weights.
    pub total: f64,
}

impl Alias {
    /// Of weights that are finite and not negative; with a total of 0 all are equally likely.
    pub fn new(weights: &[f64]) -> Self {
        let total: f64 = weights.iter().sum();
        let mean = total / weights.len().max(1) as f64;
        let mut entries: Vec<(u32, f32)> = (0..weights.len() as u32).map(|i| (i, 1.0)).collect();
        if mean <= 0.0 {
            return Self { entries, total };
        }
        let mut left: Vec<f64> = weights.iter().map(|w| w / mean).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..left.len()).partition(|&i| left[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            entries[s] = (l as u32, left[s] as f32);
            left[l] -= 1.0 - left[s];
            if left[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Self { entries, total }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alias_table_gives_every_entry_its_share() {
        let weights = [0.0, 3.0, 1.0, 0.5, 10.0, 0.25];
        let alias = Alias::new(&weights);
        let mut shares = [0.0f64; 6];
        for (i, (other, keep)) in alias.entries.iter().enumerate() {
            shares[i] += f64::from(*keep) / 6.0;
            shares[*other as usize] += (1.0 - f64::from(*keep)) / 6.0;
        }
        for (share, weight) in shares.iter().zip(weights) {
            // Rounding of `keep` to f32.
            assert!((share - weight / alias.total).abs() < 1e-7, "{share} {weight}");
        }
        assert_eq!(Alias::new(&[0.0; 3]).entries, [(0, 1.0), (1, 1.0), (2, 1.0)]);
        assert_eq!(Alias::new(&[]).total, 0.0);
    }
}
