//! `log.json`: adapter, settings, milliseconds and counts of each frame, bytes that were allocated.
//!
//! A number that the adapter or the chosen stages do not give is `null`, never a guess.

use crate::RenderSettings;
use frame::{FrameLog, Gpu, Room};
use serde::Serialize;
use std::collections::BTreeMap;

/// The stages in the order of the street.
pub const STAGES: [&str; 6] = ["tessellate", "voxel", "gather", "trace", "denoise", "upsample"];

/// Counts that are always listed, `null` where nobody counted.
const COUNTS: [&str; 6] = ["rays", "voxels", "bricks", "cut_rays", "clamped", "mean_spp"];

/// The whole file.
#[derive(Debug, Serialize)]
pub struct Log {
    /// What it ran on.
    pub adapter: Adapter,
    /// What was asked for.
    pub settings: RenderSettings,
    /// One per frame.
    pub frames: Vec<Frame>,
    /// After the last frame.
    pub memory_bytes: MemoryBytes,
}

/// The graphics adapter and its driver.
#[derive(Debug, Serialize)]
pub struct Adapter {
    /// As the driver calls it.
    pub name: String,
    /// `DiscreteGpu`, `Cpu` and so on.
    pub kind: String,
    /// `vulkan`, `metal`, `dx12`.
    pub backend: String,
    /// Name of the driver.
    pub driver: String,
    /// Its version and the like.
    pub driver_info: String,
    /// Whether passes can be timed.
    pub timestamps: bool,
    /// Loop iterations after which the driver ends all loops, if it does.
    pub loop_cap: Option<u32>,
}

/// One frame.
#[derive(Debug, Serialize)]
pub struct Frame {
    /// In the order they first ran.
    pub passes: Vec<Pass>,
    /// Sum per stage; 0 for a stage that ran nothing.
    pub stages_ms: BTreeMap<&'static str, Option<f64>>,
    /// All passes.
    pub total_ms: Option<f64>,
    /// Rays, voxels and the like.
    pub counts: BTreeMap<String, Option<f64>>,
}

/// All passes of one name.
#[derive(Debug, Serialize)]
pub struct Pass {
    /// Path: stage, implementation, part.
    pub name: String,
    /// Sum over its runs.
    pub gpu_ms: Option<f64>,
    /// How often it ran.
    pub runs: u32,
}

/// Bytes allocated on the adapter.
#[derive(Debug, Serialize)]
pub struct MemoryBytes {
    /// Meshes, materials, textures, sky.
    pub scene: u64,
    /// The voxel grid.
    pub voxels: u64,
    /// The most that voxels and building them took at once.
    pub voxels_peak: u64,
    /// G-buffers of both sizes.
    pub gbuffer: u64,
    /// Light on its way, and the picture.
    pub radiance: u64,
    /// What filters keep from frame to frame.
    pub history: u64,
    /// Triangle search structures.
    pub bvh: u64,
}

impl Adapter {
    /// Describes the adapter; measures its loop cap if nobody has.
    pub fn of(gpu: &Gpu) -> Self {
        Self {
            name: gpu.info.name.clone(),
            kind: format!("{:?}", gpu.info.device_type),
            backend: gpu.info.backend.to_string(),
            driver: gpu.info.driver.clone(),
            driver_info: gpu.info.driver_info.clone(),
            timestamps: gpu.timestamp_period.is_some(),
            loop_cap: gpu.loop_cap(),
        }
    }
}

impl Frame {
    /// From what the recorder collected.
    pub fn of(log: &FrameLog) -> Self {
        let mut counts: BTreeMap<String, Option<f64>> = COUNTS.map(|name| (name.into(), None)).into();
        counts.extend(log.counts.iter().map(|(name, count)| (name.clone(), Some(*count))));
        Self {
            passes: log
                .passes
                .iter()
                .map(|p| Pass { name: p.name.clone(), gpu_ms: p.gpu_ms, runs: p.runs })
                .collect(),
            // An empty sum is -0.0; nobody wants to read that.
            stages_ms: STAGES.map(|stage| (stage, log.stage_ms(stage).map(|ms| ms + 0.0))).into(),
            total_ms: log.total_ms(),
            counts,
        }
    }
}

impl MemoryBytes {
    /// What is allocated now, from the ledger.
    pub fn of(gpu: &Gpu) -> Self {
        let live = |room| gpu.memory(room).live;
        Self {
            scene: live(Room::Scene),
            voxels: live(Room::Voxels),
            voxels_peak: gpu.memory(Room::Voxels).peak,
            gbuffer: live(Room::GBuffer),
            radiance: live(Room::Radiance),
            history: live(Room::History),
            bvh: live(Room::Bvh),
        }
    }

    /// Name and bytes, in the order they are printed.
    pub fn list(&self) -> [(&'static str, u64); 7] {
        [
            ("scene", self.scene),
            ("voxels", self.voxels),
            ("voxels_peak", self.voxels_peak),
            ("gbuffer", self.gbuffer),
            ("radiance", self.radiance),
            ("history", self.history),
            ("bvh", self.bvh),
        ]
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use frame::PassLog;

    fn pass(name: &str, gpu_ms: Option<f64>) -> PassLog {
        PassLog { name: name.into(), gpu_ms, runs: 2 }
    }

    #[test]
    fn stages_sum_their_passes_and_idle_ones_are_zero() {
        let log = FrameLog {
            passes: vec![
                pass("trace/voxel", Some(2.0)),
                pass("trace/resolve", Some(0.5)),
                pass("gather/trace", Some(1.0)),
            ],
            counts: [("rays".to_owned(), 12.0)].into(),
            ..Default::default()
        };
        let json = serde_json::to_value(Frame::of(&log)).unwrap();
        assert_eq!(json["stages_ms"]["trace"], 2.5);
        assert_eq!(json["stages_ms"]["denoise"], 0.0);
        assert_eq!(json["total_ms"], 3.5);
        assert_eq!(json["passes"][0]["name"], "trace/voxel");
        assert_eq!(json["counts"]["rays"], 12.0);
        assert!(json["counts"]["cut_rays"].is_null());
        for stage in STAGES {
            assert!(json["stages_ms"].get(stage).is_some(), "{stage}");
        }
    }

    #[test]
    fn an_adapter_without_timestamps_gives_null() {
        let log = FrameLog { passes: vec![pass("trace/voxel", None)], ..Default::default() };
        let json = serde_json::to_value(Frame::of(&log)).unwrap();
        assert!(json["stages_ms"]["trace"].is_null() && json["total_ms"].is_null());
        assert!(json["passes"][0]["gpu_ms"].is_null());
    }
}
