//! Where triangles lie on a lightmap, and how a field is read from it.

use glam::{Vec2, Vec3};

/// The places of a scene's triangles on the pages of a lightmap. A page is a picture; its first row is row 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Charts {
    /// Columns and rows of a page.
    pub page_size: [u32; 2],
    /// Pages.
    pub page_count: u32,
    /// The page of each triangle.
    pub pages: Vec<u32>,
    /// The chart of each triangle: a connected part of the map; `u32::MAX` for triangles without a place.
    pub chart_of_triangle: Vec<u32>,
    /// Each triangle's corners on its page, in texels: texel (0, 0) covers [0, 1]².
    pub coordinates: Vec<[Vec2; 3]>,
}

impl Charts {
    /// Texels of all pages, covered or not.
    pub fn pixel_count(&self) -> usize {
        self.page_size[0] as usize * self.page_size[1] as usize * self.page_count as usize
    }

    /// The number of a texel among those of all pages: page by page, row by row.
    pub fn pixel(&self, page: u32, column: u32, row: u32) -> usize {
        let [width, height] = self.page_size.map(|side| side as usize);
        (page as usize * height + row as usize) * width + column as usize
    }

    /// Page, column and row of a texel's number.
    pub fn place(&self, pixel: usize) -> [u32; 3] {
        let [width, height] = self.page_size.map(|side| side as usize);
        [pixel / width / height, pixel % width, pixel / width % height].map(|value| value as u32)
    }

    /// A point of a triangle on its page, in texels.
    pub fn map_point(&self, triangle: u32, barycentric: Vec2) -> Vec2 {
        let [a, b, c] = self.coordinates[triangle as usize];
        (1.0 - barycentric.x - barycentric.y) * a + barycentric.x * b + barycentric.y * c
    }

    /// A field given for every texel of all pages, at a point of a triangle: bilinear between texel centres.
    pub fn interpolate(&self, field: &[Vec3], triangle: u32, barycentric: Vec2) -> Vec3 {
        let page = self.pages[triangle as usize];
        let place = self.map_point(triangle, barycentric) - 0.5;
        let corner = place.floor();
        let fraction = place - corner;
        let at = |x: f32, y: f32| {
            let inside = |value: f32, side: u32| value.clamp(0.0, side as f32 - 1.0) as u32;
            let [width, height] = self.page_size;
            field[self.pixel(page, inside(corner.x + x, width), inside(corner.y + y, height))]
        };
        let upper = at(0.0, 0.0).lerp(at(1.0, 0.0), fraction.x);
        let lower = at(0.0, 1.0).lerp(at(1.0, 1.0), fraction.x);
        upper.lerp(lower, fraction.y)
    }

    /// A hash of all places, as 64 hexadecimal digits: a lightmap's values are bound to it.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(bytemuck::cast_slice(&self.page_size));
        hasher.update(&self.page_count.to_le_bytes());
        hasher.update(bytemuck::cast_slice(&self.pages));
        hasher.update(bytemuck::cast_slice(&self.coordinates));
        hasher.finalize().to_hex().to_string()
    }
}
