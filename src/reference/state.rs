//! `reference.state`: all that a run needs to go on, written whole or not at all.
//!
//! A first line that names the format, a line of JSON with what was rendered, then little endian: samples and batches (u64), sums
//! and sums of squares (3 f64 a pixel each), and a checksum (CRC-32) of all before it. A file that does not hold what it
//! says is refused, never guessed from.

use super::Moments;
use crate::{Error, output};
use serde_json::Value;
use std::path::Path;

const FORMAT: &str = "gridlight reference 2";

/// Writes the state of a run that renders `key`.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, key: &Value, moments: &Moments) -> Result<(), Error> {
    let mut bytes = format!("{FORMAT}\n{key}\n").into_bytes();
    bytes.extend(moments.count.to_le_bytes());
    bytes.extend(moments.batches.to_le_bytes());
    for value in moments.sums.iter().chain(&moments.squares).flatten() {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    output::write(path, &bytes)
}

/// Reads the state of an earlier run of the same `key`; none where there is no file.
///
/// # Errors
/// The file cannot be read, is broken, or belongs to something else: the message says what differs.
pub fn read(path: &Path, key: &Value, size: [u32; 2]) -> Result<Option<Moments>, Error> {
    let fail = |message: String| Error::Read { path: path.into(), message };
    let bytes = match std::fs::read(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(fail(e.to_string())),
        Ok(bytes) => bytes,
    };
    let broken = |what: &str| fail(format!("broken: {what}; delete it to begin anew"));
    let (content, sum) = bytes.split_last_chunk::<4>().ok_or_else(|| broken("it ends early"))?;
    if crc32fast::hash(content) != u32::from_le_bytes(*sum) {
        return Err(broken("its checksum is another"));
    }
    let mut lines = content.splitn(3, |byte| *byte == b'\n');
    if lines.next() != Some(FORMAT.as_bytes()) {
        return Err(broken(&format!("it does not begin with \"{FORMAT}\"")));
    }
    let stored: Value =
        serde_json::from_slice(lines.next().unwrap_or_default()).map_err(|e| broken(&e.to_string()))?;
    if stored != *key {
        return Err(fail(format!(
            "made with other settings ({}); choose another --out, or delete it",
            differences(&stored, key)
        )));
    }
    let body = lines.next().unwrap_or_default();
    let mut moments = Moments::new(size);
    let pixels = moments.sums.len();
    let (words, rest) = body.as_chunks::<8>();
    if words.len() != 2 + 6 * pixels || !rest.is_empty() {
        let expected = 16 + 48 * pixels;
        return Err(broken(&format!("{} bytes of sums instead of {expected}", body.len())));
    }
    let ([count, batches], words) = words.split_first_chunk().ok_or_else(|| broken("it holds no sums"))?;
    moments.count = u64::from_le_bytes(*count);
    moments.batches = u64::from_le_bytes(*batches);
    let places = moments.sums.iter_mut().chain(&mut moments.squares).flatten();
    for (place, word) in places.zip(words) {
        *place = f64::from_le_bytes(*word);
    }
    Ok(Some(moments))
}

/// What two keys say differently, each with both values.
fn differences(stored: &Value, wanted: &Value) -> String {
    let empty = serde_json::Map::new();
    let [a, b] = [stored, wanted].map(|v| v.as_object().unwrap_or(&empty));
    let names: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let say = |v: Option<&Value>| v.map_or("nothing".into(), Value::to_string);
    names
        .into_iter()
        .filter(|name| a.get(*name) != b.get(*name))
        .map(|name| format!("{name}: {} there, {} now", say(a.get(name)), say(b.get(name))))
        .collect::<Vec<_>>()
        .join("; ")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use serde_json::json;

    fn scratch(name: &str) -> std::path::PathBuf {
        std::env::temp_dir().join(format!("gridlight-state-{}-{name}", std::process::id()))
    }

    #[test]
    fn a_state_comes_back_to_the_bit_and_a_broken_one_is_refused() {
        let path = scratch("whole");
        let mut moments = Moments::new([2, 1]);
        moments.count = 5;
        moments.batches = 2;
        moments.sums = vec![[0.1, 1e-300, 3.0], [f64::MAX, 0.0, 2.0]];
        moments.squares[1] = [7.0, 8.0, 9.0];
        let key = json!({ "scene": "a\nb", "grid": 64 });
        assert_eq!(read(&path, &key, [2, 1]).unwrap(), None);
        write(&path, &key, &moments).unwrap();
        assert_eq!(read(&path, &key, [2, 1]).unwrap().as_ref(), Some(&moments));

        let message = read(&path, &json!({ "scene": "a\nb", "grid": 128 }), [2, 1]).unwrap_err().to_string();
        assert!(message.contains("grid: 64 there, 128 now"), "{message}");

        let whole = std::fs::read(&path).unwrap();
        for at in [0, 30, whole.len() / 2, whole.len() - 1] {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            std::fs::write(&path, &bytes).unwrap();
            assert!(read(&path, &key, [2, 1]).unwrap_err().to_string().contains("broken"), "byte {at}");
        }
        for length in [0, 3, 20, whole.len() - 5] {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read(&path, &key, [2, 1]).unwrap_err().to_string().contains("broken"), "{length} bytes");
        }
        std::fs::remove_file(&path).unwrap();
    }
}
