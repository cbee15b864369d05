//! What outlives a run: recent scenes and kept presets, in `gridlight/viewer.json` of the user's configuration folder.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Scenes that are remembered.
const RECENT: usize = 12;

/// The file's contents, and what is being written into the panels.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Store {
    /// Paths, newest first.
    pub recent_scenes: Vec<String>,
    /// Name and the line that it stands for.
    pub presets: Vec<(String, String)>,
    /// The line that the user is writing; none while it follows the settings.
    #[serde(skip)]
    pub edited_line: Option<String>,
    /// The name of the preset to be.
    #[serde(skip)]
    pub new_preset: String,
    #[serde(skip)]
    file: Option<PathBuf>,
}

impl Store {
    /// Reads the user's; one that is missing or broken is empty.
    pub fn of_user() -> Self {
        Self::in_file(file())
    }

    fn in_file(file: Option<PathBuf>) -> Self {
        let text = file.as_ref().and_then(|file| std::fs::read_to_string(file).ok());
        let read: Option<Self> = text.and_then(|text| serde_json::from_str(&text).ok());
        Self { file, ..read.unwrap_or_default() }
    }

    /// Remembers a scene that was opened.
    pub fn opened(&mut self, scene: &str) {
        if scene::built_in::by_name(scene).is_some() || self.recent_scenes.first().is_some_and(|s| s == scene)
        {
            return;
        }
        self.recent_scenes.retain(|known| known != scene);
        self.recent_scenes.insert(0, scene.into());
        self.recent_scenes.truncate(RECENT);
        self.save();
    }

    /// Keeps a line under the name that was typed.
    pub fn keep_preset(&mut self, line: String) {
        let name = std::mem::take(&mut self.new_preset).trim().to_owned();
        self.presets.retain(|(known, _)| *known != name);
        self.presets.push((name, line));
        self.save();
    }

    /// A folder that cannot be written to is no reason to stop: the next run then begins empty.
    fn save(&self) {
        let Some(file) = &self.file else { return };
        let written = file.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| {
            let text = serde_json::to_string_pretty(self)?;
            std::fs::write(file, text)
        });
        if let Err(e) = written {
            eprintln!("warning: {}: {e}", file.display());
        }
    }
}

/// Where it lies, by the conventions of Linux, macOS and Windows.
fn file() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let folder = variable("XDG_CONFIG_HOME")
        .or_else(|| variable("APPDATA"))
        .or_else(|| variable("HOME").map(|home| home.join(".config")))?;
    Some(folder.join("gridlight/viewer.json"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_there_again() {
        let file = std::env::temp_dir().join(format!("gridlight-store-{}/viewer.json", std::process::id()));
        let mut store = Store::in_file(Some(file.clone()));
        for scene in ["a.glb", "cornell", "b.glb", "a.glb"] {
            store.opened(scene);
        }
        store.new_preset = " fast ".into();
        store.keep_preset("gridlight render cornell --spp 1".into());
        let again = Store::in_file(Some(file.clone()));
        assert_eq!(again.recent_scenes, ["a.glb", "b.glb"]);
        assert_eq!(again.presets, [("fast".into(), "gridlight render cornell --spp 1".into())]);
        std::fs::write(&file, "{").ok();
        assert!(Store::in_file(Some(file.clone())).recent_scenes.is_empty());
        std::fs::remove_dir_all(file.parent().unwrap_or(&file)).ok();
    }
}
