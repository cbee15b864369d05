//! Everything that can end a run, each message with the thing, the place and both values.

use std::path::PathBuf;

/// What went wrong, and whether the asking or the doing was at fault ([`Error::is_usage`]).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Loading the scene, its sky, or a setting about them.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// The adapter, the driver, or memory.
    #[error(transparent)]
    Gpu(#[from] frame::GpuError),
    /// The scene does not fit the GPU.
    #[error(transparent)]
    SceneGpu(#[from] frame::scene_gpu::SceneGpuError),
    /// The scene does not fit the grid.
    #[error(transparent)]
    Voxel(#[from] voxel::VoxelError),
    /// A knob that is not there, or a value it does not take.
    #[error("--set {id}: {source}")]
    Knob {
        /// The stage.
        id: String,
        /// What its knobs say.
        source: frame::KnobError,
    },
    /// `--set` names something that takes no part in this render.
    #[error("--set {id}.{knob}: no such part in this render; there are: {known}")]
    NoSuchStage {
        /// As given.
        id: String,
        /// The knob asked for.
        knob: String,
        /// The ids that have knobs.
        known: String,
    },
    /// A stage was asked for by a name that is not in its list.
    #[error("no {kind} \"{name}\"; there are: {known}")]
    NoSuchName {
        /// What was to be chosen.
        kind: &'static str,
        /// As given.
        name: String,
        /// Those there are.
        known: String,
    },
    /// Neither a scene nor a case was named.
    #[error("a scene or --case is needed; `gridlight list` has the built-in scenes")]
    NoScene,
    /// Eye and target are one point.
    #[error("the camera looks nowhere: --eye and --target are both {at:?}")]
    LooksNowhere {
        /// That point.
        at: [f32; 3],
    },
    /// `--camera` names one that the scene does not have.
    #[error("no camera {index} in {scene}: it has {count}, numbered from 0")]
    NoSuchCamera {
        /// The scene.
        scene: String,
        /// As given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// `--case` without the table of cases, or with one that says something else.
    #[error("--case {name}: {message}")]
    Case {
        /// As given.
        name: String,
        /// What is wrong, and where.
        message: String,
    },
    /// The wide BVH cannot be built.
    #[error(transparent)]
    Cwbvh(#[from] tracer::bvh::cwbvh::CwbvhError),
    /// A file could not be read, or is not what it should be.
    #[error("{path}: {message}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words, the decoder's, or what is missing.
        message: String,
    },
    /// Two pictures that cannot be compared.
    #[error("{reference} (reference), {test} (test): {source}", reference = reference.display(), test = test.display())]
    Metrics {
        /// Its file.
        reference: PathBuf,
        /// Its file.
        test: PathBuf,
        /// Why, with the place and both values.
        source: crate::metrics::MetricError,
    },
    /// More shards than combinations.
    #[error("--shard {index}/{count}: there are fewer than {index} combinations")]
    NothingToCompare {
        /// Which share, from 1.
        index: usize,
        /// Of how many.
        count: usize,
    },
    /// Shards of a comparison that do not make one, or a picture of it that is not there.
    #[error(transparent)]
    Report(#[from] crate::report::MergeError),
    /// A file could not be written.
    #[error("{path}: {message}", path = path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's words, or the encoder's.
        message: String,
    },
}

impl Error {
    /// Whether the command line was wrong (exit code 2), not the run (exit code 1).
    pub fn is_usage(&self) -> bool {
        use scene::SceneError::NoSuchMaterial;
        matches!(
            self,
            Self::Knob { .. }
                | Self::NoSuchStage { .. }
                | Self::NoSuchName { .. }
                | Self::NoScene
                | Self::LooksNowhere { .. }
                | Self::NoSuchCamera { .. }
                | Self::Case { .. }
                | Self::Scene(NoSuchMaterial { .. })
        )
    }
}
