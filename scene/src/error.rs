//! What can go wrong while loading: the thing, the place, both values.

use std::path::PathBuf;

/// Every way a scene, a sky or a setting about them can be refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a built-in scene nor a glTF path.
    #[error("no scene \"{name}\": neither a built-in ({known}) nor a .gltf or .glb file")]
    NoSuchScene {
        /// As given.
        name: String,
        /// The built-in names.
        known: String,
    },
    /// The file cannot be read, breaks the format, asks for what is not supported, or for more than the budget.
    #[error("{path}: {message}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and where in the file.
        message: String,
    },
    /// `--emit` names a material that is not there.
    #[error("no material \"{name}\" in this scene; it has: {known}")]
    NoSuchMaterial {
        /// As given.
        name: String,
        /// The scene's materials.
        known: String,
    },
}
