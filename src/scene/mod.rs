//! Scenes: what is read from files, repaired, and cut into elements.
//!
//! Everything in a [`Scene`] is in **local units**: centred on the scene's bounding box and scaled by a power of two
//! so that the largest half-extent lies in (1/2, 1]. So no code behind this module meets a scene that is a million
//! metres wide or far from zero. [`LocalFrame`] is the only way in and out.

pub mod area_light;
pub mod builtin;
pub mod camera;
pub mod error;
pub mod inspect;
pub mod load;
pub mod local_frame;
pub mod material;
pub mod mesh;
pub mod options;
pub mod reflectance;
pub mod tessellate;
pub mod texture;

use glam::{DVec3, Vec2, Vec3};

pub use area_light::AreaLight;
pub use camera::Camera;
pub use error::SceneError;
pub use local_frame::LocalFrame;
pub use material::Material;
pub use mesh::Mesh;
pub use options::LoadOptions;
pub use tessellate::Tessellation;
pub use texture::Texture;

/// A scene: triangles with materials, in local units.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The name shown to people, from the file's name.
    pub name: String,
    /// The triangles as they were read (and repaired), before any tessellation.
    pub mesh: Mesh,
    /// Materials, indexed by [`Mesh::material_indices`]. Never empty.
    pub materials: Vec<Material>,
    /// Textures, indexed by the materials.
    pub textures: Vec<Texture>,
    /// How local units relate to the file's metres.
    pub frame: LocalFrame,
    /// What the file has where no light ever comes, enclosed in solids that touch, and what is left out of the mesh: the
    /// corners of those places [local units].
    pub enclosed: Vec<[Vec3; 3]>,
    /// If set, the second half of the mesh's triangles are the flipped copies of the first half.
    pub two_sided: bool,
    /// Triangles are flat whatever their normals say: rays do not leave from the curved surface that these tell of.
    pub faceted: bool,
    /// What was dropped, repaired or missing at load; one line each, in the order met.
    pub warnings: Vec<String>,
}

impl Scene {
    /// The least and greatest coordinates of all vertices, in metres.
    pub fn bounds_in_metres(&self) -> (DVec3, DVec3) {
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) =
            self.mesh.positions.iter().fold(none, |(low, high), point| (low.min(*point), high.max(*point)));
        (self.frame.point_to_metres(low), self.frame.point_to_metres(high))
    }

    /// The material of a triangle.
    pub fn material(&self, triangle: u32) -> &Material {
        &self.materials[self.mesh.material_indices[triangle as usize] as usize]
    }

    /// Reflectance at a point of a triangle: `Kd` times the decoded `map_Kd`.
    pub fn reflectance(&self, triangle: u32, barycentric: Vec2) -> Vec3 {
        self.material(triangle).reflectance * self.texture_color(triangle, barycentric)
    }

    /// The decoded `map_Kd` at a point of a triangle; 1 without one.
    pub fn texture_color(&self, triangle: u32, barycentric: Vec2) -> Vec3 {
        let Some(texture) = self.material(triangle).reflectance_texture else { return Vec3::ONE };
        self.textures[texture as usize].sample(self.mesh.texcoord(triangle, barycentric))
    }

    /// True if any material's reflectance is multiplied by a texture.
    pub fn has_reflectance_textures(&self) -> bool {
        self.materials.iter().any(|material| material.reflectance_texture.is_some())
    }

    /// True where an alpha-tested cut-out lets rays through.
    pub fn is_cut_out(&self, triangle: u32, barycentric: Vec2) -> bool {
        let material = self.material(triangle);
        let texture_opacity = material.opacity_texture.map_or(1.0, |texture| {
            self.textures[texture as usize].sample_opacity(self.mesh.texcoord(triangle, barycentric))
        });
        material.opacity * texture_opacity < 0.5
    }

    /// True if any of the triangle's points can be cut out, so that hits on it must be tested.
    pub fn may_be_cut_out(&self, triangle: u32) -> bool {
        let material = self.material(triangle);
        material.opacity_texture.is_some() || material.opacity < 0.5
    }

    /// Triangles whose material emits.
    pub fn emissive_triangles(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.mesh.triangles.len() as u32)
            .filter(|&triangle| self.material(triangle).emitted_radiance.max_element() > 0.0)
    }

    /// A hash of everything a solution depends on (geometry, normals, texture coordinates, materials, textures,
    /// scale), as 64 hexadecimal digits. Solutions are bound to it.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mesh = &self.mesh;
        hasher.update(bytemuck::cast_slice(&mesh.positions));
        hasher.update(bytemuck::cast_slice(&mesh.normals));
        hasher.update(bytemuck::cast_slice(&mesh.triangles));
        hasher.update(bytemuck::cast_slice(&mesh.texcoords));
        hasher.update(bytemuck::cast_slice(&mesh.material_indices));
        for material in &self.materials {
            hasher.update(bytemuck::cast_slice(&material.reflectance.to_array()));
            hasher.update(bytemuck::cast_slice(&material.emitted_radiance.to_array()));
            hasher.update(&material.opacity.to_le_bytes());
            for texture in [material.reflectance_texture, material.opacity_texture] {
                hasher.update(&texture.map_or(u32::MAX, |index| index).to_le_bytes());
            }
        }
        for texture in &self.textures {
            texture.hash_into(&mut hasher);
        }
        hasher.update(&self.frame.metres_per_unit.to_le_bytes());
        hasher.update(&[u8::from(self.two_sided)]);
        if self.faceted {
            hasher.update(b"faceted");
        }
        hasher.finalize().to_hex().to_string()
    }
}
