//! What a scene needs modelled, decided once at load: stages build only that, and pay for nothing else.

use crate::{Alpha, Scene, Sky};
use std::fmt;

/// One yes or no per feature that costs bytes or instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneNeeds {
    /// Some surface gives off light.
    pub emission: bool,
    /// Some surface reflects specularly (metal, or a dielectric coat).
    pub specular: bool,
    /// Some surface has two different roughnesses.
    pub anisotropy: bool,
    /// Some surface lets light through.
    pub transmission: bool,
    /// Some transmissive solid absorbs.
    pub absorption: bool,
    /// Some surface is cut out or blended.
    pub coverage: bool,
    /// Some material has a normal map.
    pub normal_maps: bool,
    /// Some material reads the second set of texture coordinates.
    pub second_uv: bool,
    /// Some mesh has vertex colours.
    pub vertex_colors: bool,
    /// Something moves.
    pub motion: bool,
    /// Some material has a height map.
    pub height_maps: bool,
    /// There is a sky map.
    pub sky_map: bool,
    /// There are punctual lights or a sun.
    pub shadow_rays: bool,
}

impl SceneNeeds {
    /// Looks at every material that a triangle uses.
    pub fn of(scene: &Scene) -> Self {
        let mut used = vec![false; scene.materials.len()];
        for triangle in &scene.rest().triangles {
            if let Some(flag) = used.get_mut(triangle.material as usize) {
                *flag = true;
            }
        }
        let mut needs = Self {
            second_uv: !scene.rest().uv1.is_empty(),
            vertex_colors: !scene.rest().colors.is_empty(),
            motion: scene.rest().objects.iter().any(|o| o.moving),
            sky_map: matches!(scene.sky, Sky::Map(_)),
            shadow_rays: scene.sun.is_some() || !scene.rest().lights.is_empty(),
            ..Self::default()
        };
        for material in scene.materials.iter().zip(used).filter(|(_, used)| *used).map(|(m, _)| m) {
            needs.emission |= material.emits();
            needs.specular |=
                material.metallic > 0.0 || material.specular > 0.0 || material.transmission > 0.0;
            needs.anisotropy |= material.anisotropy > 0.0;
            needs.transmission |= material.transmission > 0.0;
            needs.absorption |= material.transmission > 0.0
                && material.volume.is_some_and(|v| v.absorption().max_element() > 0.0);
            needs.coverage |= material.alpha != Alpha::Opaque;
            needs.normal_maps |= material.normal_texture.is_some();
            needs.height_maps |= material.height.is_some();
        }
        needs
    }

    /// Each feature by name, in a fixed order, for logs and `info`.
    pub fn list(&self) -> [(&'static str, bool); 13] {
        [
            ("emission", self.emission),
            ("specular", self.specular),
            ("anisotropy", self.anisotropy),
            ("transmission", self.transmission),
            ("absorption", self.absorption),
            ("coverage", self.coverage),
            ("normal_maps", self.normal_maps),
            ("second_uv", self.second_uv),
            ("vertex_colors", self.vertex_colors),
            ("motion", self.motion),
            ("height_maps", self.height_maps),
            ("sky_map", self.sky_map),
            ("shadow_rays", self.shadow_rays),
        ]
    }
}

impl fmt::Display for SceneNeeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let needed: Vec<_> = self.list().into_iter().filter(|(_, on)| *on).map(|(name, _)| name).collect();
        f.write_str(if needed.is_empty() { "nothing beyond Lambert" } else { "" })?;
        f.write_str(&needed.join(" "))
    }
}
