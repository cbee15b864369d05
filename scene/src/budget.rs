//! What loading may take: one count of bytes over everything a file makes us hold, checked before memory is asked for.
//!
//! A few bytes of a file can ask for gigabytes (an accessor without bytes of its own, a header that claims a huge
//! picture, one mesh placed a million times), so what is counted is what is claimed, not what is there. The count is of
//! what loading holds and works with, never given back; it is within a small factor of the process's peak, and never
//! depends on the machine.

use std::cell::Cell;
use std::fmt;
use std::io::Read;
use std::path::Path;

/// Most bytes that loading one scene or one sky may take (`--load-mb`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadBudget {
    /// Bytes.
    pub bytes: u64,
}

impl LoadBudget {
    /// So many megabytes (10^6 bytes).
    pub const fn megabytes(megabytes: u64) -> Self {
        Self { bytes: megabytes.saturating_mul(1_000_000) }
    }
}

impl Default for LoadBudget {
    /// 2000 MB: far more than any scene measured here takes, and what a small machine can give.
    fn default() -> Self {
        Self::megabytes(2000)
    }
}

/// Bytes taken so far, and the most there may be.
#[derive(Debug)]
pub(crate) struct Meter {
    most: u64,
    taken: Cell<u64>,
}

/// More was asked for than there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OverBudget {
    /// Bytes asked for; saturated.
    asked: u64,
    taken: u64,
    most: u64,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
        write!(
            f,
            "takes {} MB on top of {} MB, the budget for loading is {} MB (--load-mb)",
            megabytes(self.asked),
            megabytes(self.taken),
            megabytes(self.most)
        )
    }
}

impl From<OverBudget> for String {
    fn from(over: OverBudget) -> Self {
        over.to_string()
    }
}

impl Meter {
    pub(crate) fn new(budget: LoadBudget) -> Self {
        Self { most: budget.bytes, taken: Cell::new(0) }
    }

    /// Takes `count` things of `size` bytes each, before they are made.
    pub(crate) fn take(&self, count: u64, size: u64) -> Result<(), OverBudget> {
        let asked = count.saturating_mul(size);
        let taken = self.taken.get();
        match taken.checked_add(asked).filter(|all| *all <= self.most) {
            Some(all) => {
                self.taken.set(all);
                Ok(())
            }
            None => Err(OverBudget { asked, taken, most: self.most }),
        }
    }

    /// Reads a file whole. What is no file (a folder, a pipe, a device: some never end) is refused before it is opened.
    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, String> {
        let fail = |e: std::io::Error| e.to_string();
        let found = std::fs::metadata(path).map_err(fail)?;
        if !found.is_file() {
            return Err("not a file".into());
        }
        self.take(found.len(), 1)?;
        let mut bytes = Vec::new();
        // A file that grows while it is read is cut where it ended when it was measured.
        std::fs::File::open(path).map_err(fail)?.take(found.len()).read_to_end(&mut bytes).map_err(fail)?;
        Ok(bytes)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_adds_up_to_the_budget_and_no_further() {
        let meter = Meter::new(LoadBudget { bytes: 100 });
        assert!(meter.take(10, 9).is_ok() && meter.take(10, 1).is_ok() && meter.take(0, u64::MAX).is_ok());
        let over = meter.take(1, 1).unwrap_err();
        assert_eq!((over.asked, over.taken, over.most), (1, 100, 100));
        assert_eq!(meter.take(u64::MAX, u64::MAX).unwrap_err().asked, u64::MAX);
    }

    #[test]
    fn a_refusal_has_the_three_numbers_and_the_flag() {
        let meter = Meter::new(LoadBudget::megabytes(2));
        meter.take(1_500_000, 1).unwrap();
        let message = meter.take(3, 1_000_000).unwrap_err().to_string();
        assert_eq!(message, "takes 3 MB on top of 2 MB, the budget for loading is 2 MB (--load-mb)");
    }

    #[test]
    fn what_never_ends_is_not_read() {
        let meter = Meter::new(LoadBudget::default());
        assert_eq!(meter.read(&std::env::temp_dir()).unwrap_err(), "not a file");
        if Path::new("/dev/zero").exists() {
            assert_eq!(meter.read(Path::new("/dev/zero")).unwrap_err(), "not a file");
        }
    }
}
