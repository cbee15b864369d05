//! Shader files, watched: what each said when the program was built, and what it says now.
//!
//! Texts are taken as built in at the start. A file that was edited between build and start is in no kernel as it is;
//! editing it again says so.

use notify::{RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Folders of folders that are looked into.
const DEEPEST: u32 = 6;

struct File {
    built: String,
    now: String,
}

/// One file's change.
pub struct Change {
    /// For messages.
    pub path: PathBuf,
    /// As the program was built.
    pub built: String,
    /// Before the change: what the kernels in use are made of.
    pub before: String,
    /// What it says now.
    pub now: String,
}

/// The shader files of a folder.
#[derive(Default)]
pub struct Shaders {
    files: HashMap<PathBuf, File>,
    /// Watches as long as it lives.
    _watcher: Option<RecommendedWatcher>,
}

impl Shaders {
    /// Reads the shaders in a folder and those below it, and tells of each that changes.
    ///
    /// # Errors
    /// The system gives no watcher.
    pub fn watch(folder: &Path, tell: impl Fn(PathBuf) + Send + 'static) -> notify::Result<Self> {
        let mut paths = Vec::new();
        find(folder, DEEPEST, &mut paths);
        let read = |path: PathBuf| {
            let text = std::fs::read_to_string(&path).ok()?;
            Some((path, File { built: text.clone(), now: text }))
        };
        let files: HashMap<_, _> = paths.into_iter().filter_map(read).collect();
        let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            // What cannot be watched for a moment is edited again.
            let paths = event.map(|event| event.paths).unwrap_or_default();
            paths.into_iter().filter(|path| is_shader(path)).for_each(&tell);
        })?;
        // Folders, and not files: editors put another file in the place of the one they save.
        let folders: BTreeSet<_> = files.keys().filter_map(|path| path.parent()).collect();
        for folder in folders {
            watcher.watch(folder, RecursiveMode::NonRecursive)?;
        }
        Ok(Self { files, _watcher: Some(watcher) })
    }

    /// What became of a file; none if it says what it said, or nothing, as while it is being written.
    pub fn read(&mut self, path: &Path) -> Option<Change> {
        let file = self.files.get_mut(path)?;
        let now =
            std::fs::read_to_string(path).ok().filter(|text| !text.trim().is_empty() && *text != file.now)?;
        let before = std::mem::replace(&mut file.now, now.clone());
        Some(Change { path: path.into(), built: file.built.clone(), before, now })
    }

    /// Files that do not say what they did when the program was built, as `(built, now)`.
    pub fn edits(&self) -> impl Iterator<Item = (&str, &str)> {
        let texts = self.files.values().map(|file| (file.built.as_str(), file.now.as_str()));
        texts.filter(|(built, now)| built != now)
    }

    /// The kernels in use are made of what was there before, though the file says otherwise.
    pub fn refuse(&mut self, change: &Change) {
        if let Some(file) = self.files.get_mut(&change.path) {
            file.now.clone_from(&change.before);
        }
    }
}

fn is_shader(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "wgsl")
}

fn find(folder: &Path, depth: u32, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for (path, kind) in entries.filter_map(|entry| Some((entry.path(), entry.file_type().ok()?))) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if kind.is_file() && is_shader(&path) {
            found.push(path);
        } else if kind.is_dir() && depth > 0 && name != "target" && !name.starts_with('.') {
            find(&path, depth - 1, found);
        }
    }
}
