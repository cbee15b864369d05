//! One share of a comparison that several machines, or several runs, split among them: `--shard 2/3`.
//!
//! Work is dealt out like cards, so that neighbours, which take about as long, end up in different shards.

use std::str::FromStr;

/// The `index`-th of `count` shares, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 1..=count.
    pub index: usize,
    /// At least 1.
    pub count: usize,
}

impl Shard {
    /// Whether the `k`-th piece of work, counted from 0, is this shard's.
    pub fn takes(&self, k: usize) -> bool {
        // A count of 0 can only come from a literal; it takes nothing.
        k.checked_rem(self.count).is_some_and(|remainder| remainder + 1 == self.index)
    }
}

impl Default for Shard {
    /// All of it.
    fn default() -> Self {
        Self { index: 1, count: 1 }
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is no shard: wanted i/n with 1 <= i <= n, such as 2/3");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let [index, count] = [index, count].map(str::parse::<usize>);
        match (index, count) {
            (Ok(index), Ok(count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_goes_to_exactly_one_shard() {
        for count in 1..=5 {
            let shards: Vec<Shard> = (1..=count).map(|i| format!("{i}/{count}").parse().unwrap()).collect();
            for k in 0..20 {
                assert_eq!(shards.iter().filter(|s| s.takes(k)).count(), 1, "piece {k} of {count} shards");
            }
        }
        assert!((0..9).all(|k| Shard::default().takes(k)));
    }

    #[test]
    fn what_is_no_shard_is_named() {
        for text in ["", "1", "0/3", "4/3", "1/0", "a/b", "1/2/3", "-1/2", "1 / 2"] {
            let message = text.parse::<Shard>().unwrap_err();
            assert!(message.contains(&format!("\"{text}\"")) && message.contains("i/n"), "{message}");
        }
    }
}
