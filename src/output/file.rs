//! Files that are there whole or not at all: written beside their place, then renamed into it.

use crate::Error;
use std::io::Write;
use std::path::Path;

/// Makes a folder and those above it.
///
/// # Errors
/// The system refuses.
pub fn folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(|e| Error::Write { path: path.into(), message: e.to_string() })
}

/// Writes a file whole or not at all, replacing one of the same name.
///
/// # Errors
/// The system refuses.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    // In the same folder, for a rename does not cross file systems; by process, for two runs may share a folder.
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = std::fs::File::create(&part)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&part, path));
    written.map_err(|e| {
        // Nothing to be done if even this fails: the first error is the one to tell.
        let _ = std::fs::remove_file(&part);
        Error::Write { path: path.into(), message: e.to_string() }
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_a_failure_leaves_nothing_behind() {
        let scratch = std::env::temp_dir().join(format!("gridlight-file-{}", std::process::id()));
        folder(&scratch).unwrap();
        let path = scratch.join("a.txt");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        // A folder in the way of the rename.
        let taken = scratch.join("taken");
        folder(&taken.join("deep")).unwrap();
        let message = write(&taken, b"three").unwrap_err().to_string();
        assert!(message.contains("taken"), "{message}");
        let left: Vec<_> = std::fs::read_dir(&scratch).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left.len(), 2, "{left:?}");
        std::fs::remove_dir_all(&scratch).unwrap();
    }
}
