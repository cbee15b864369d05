//! What both readers of skies must hold.

use scene::{LoadBudget, Sky};
use std::path::Path;

/// Reads a sky of these bytes and looks it up in a few directions.
pub fn sky(name: &str, bytes: &[u8]) {
    if bytes.len() > 1 << 16 {
        return;
    }
    match Sky::of_bytes(Path::new(name), bytes, LoadBudget::megabytes(16)) {
        Ok(sky) => {
            for direction in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, -0.0], [-1.0, 0.1, -1e-30]] {
                let radiance = sky.radiance(direction.into());
                assert!(radiance.is_finite() && radiance.min_element() >= 0.0, "{radiance} from {direction:?}");
            }
        }
        Err(fault) => {
            let message = fault.to_string();
            assert!(message.starts_with(name) && message.lines().count() == 1, "{message}");
        }
    }
}
