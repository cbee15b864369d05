//! Which configurations a comparison renders, and in which order.
//!
//! Every combination of the lists, tracers outermost: making a tracer is the dearest change. A list may name a thing twice;
//! it is rendered once. Triangles have no grid, so that their tracers appear once however many grids there are.

use crate::RenderSettings;
use crate::report::Shard;

/// The lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists {
    /// Ids.
    pub tracers: Vec<String>,
    /// Ids.
    pub denoisers: Vec<String>,
    /// Ids.
    pub upsamplers: Vec<String>,
    /// Paths per trace pixel.
    pub spp: Vec<u32>,
    /// Cells on the longest axis.
    pub grids: Vec<u32>,
}

/// Whether a tracer's paths see voxels.
pub fn traces_voxels(tracer: &str) -> bool {
    tracer.starts_with("voxel")
}

impl Lists {
    /// The combinations that a shard takes, on top of `base`.
    pub fn combinations(&self, base: &RenderSettings, shard: Shard) -> Vec<RenderSettings> {
        let mut all: Vec<RenderSettings> = Vec::new();
        for tracer in &self.tracers {
            let grids: &[u32] = if traces_voxels(tracer) { &self.grids } else { &[base.grid] };
            for &grid in grids {
                for &spp in &self.spp {
                    for denoiser in &self.denoisers {
                        for upsampler in &self.upsamplers {
                            let chosen = Self::choose(base, [tracer, denoiser, upsampler], spp, grid);
                            if !all.contains(&chosen) {
                                all.push(chosen);
                            }
                        }
                    }
                }
            }
        }
        all.into_iter().enumerate().filter(|(k, _)| shard.takes(*k)).map(|(_, settings)| settings).collect()
    }

    /// Knobs of stages that take no part are left out, for a pipeline refuses what it cannot set.
    fn choose(
        base: &RenderSettings,
        [tracer, denoiser, upsampler]: [&String; 3],
        spp: u32,
        grid: u32,
    ) -> RenderSettings {
        let ids = ["voxel", "gather", "tracer", &base.tessellator, tracer, denoiser, upsampler];
        RenderSettings {
            tracer: tracer.clone(),
            denoiser: denoiser.clone(),
            upsampler: upsampler.clone(),
            spp,
            grid,
            sets: base.sets.iter().filter(|set| ids.contains(&set.id.as_str())).cloned().collect(),
            ..base.clone()
        }
    }

    /// The knobs of `base` that none of the lists' stages has.
    pub fn unused_sets<'a>(&self, base: &'a RenderSettings) -> Option<&'a crate::settings::KnobSetting> {
        let all: Vec<&String> = self.tracers.iter().chain(&self.denoisers).chain(&self.upsamplers).collect();
        base.sets.iter().find(|set| {
            !["voxel", "gather", "tracer", &base.tessellator].contains(&set.id.as_str())
                && !all.contains(&&set.id)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::KnobSetting;

    fn lists() -> Lists {
        let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect();
        Lists {
            tracers: words(&["voxel", "bvh_lbvh"]),
            denoisers: words(&["identity", "five_phase"]),
            upsamplers: words(&["nearest"]),
            spp: vec![1, 4],
            grids: vec![64, 128],
        }
    }

    #[test]
    fn every_combination_once_and_triangles_have_no_grid() {
        let base = RenderSettings::default();
        let all = lists().combinations(&base, Shard::default());
        assert_eq!(all.len(), 2 * 2 * 2 + 2 * 2);
        assert!(all[8..].iter().all(|s| s.tracer == "bvh_lbvh" && s.grid == base.grid));
        let twice = Lists { spp: vec![1, 4, 1], ..lists() };
        assert_eq!(twice.combinations(&base, Shard::default()), all);
        let shards: usize =
            (1..=5).map(|index| lists().combinations(&base, Shard { index, count: 5 }).len()).sum();
        assert_eq!(shards, all.len());
    }

    #[test]
    fn knobs_go_to_those_who_have_them() {
        let set = |id: &str| KnobSetting { id: id.into(), knob: "k0".into(), value: "2".into() };
        let base = RenderSettings { sets: vec![set("five_phase"), set("tracer")], ..Default::default() };
        let all = lists().combinations(&base, Shard::default());
        assert!(all.iter().all(|s| s.sets.len() == if s.denoiser == "five_phase" { 2 } else { 1 }));
        assert_eq!(lists().unused_sets(&base), None);
        let base = RenderSettings { sets: vec![set("svgf")], ..Default::default() };
        assert_eq!(lists().unused_sets(&base).map(|s| s.id.as_str()), Some("svgf"));
    }
}
