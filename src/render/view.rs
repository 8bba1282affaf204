//! What a picture shows.

use std::{borrow::Cow, fmt, str::FromStr};

use glam::Vec3;

use crate::solver::{LightmapSolution, Reconstruction, Solution};

/// What a picture shows. Irradiance is shown as the radiance E/π of a white surface, so that one exposure suits all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Radiance that leaves the surfaces: emitted + ρE/π, reflectance textures per pixel.
    Radiosity,
    /// Irradiance, all bounces.
    Irradiance,
    /// Irradiance of bounce 0 alone.
    Direct,
    /// Irradiance of the bounces from 1 on.
    Indirect,
    /// Irradiance of one bounce alone.
    Bounce(usize),
    /// Shading normals: (n + 1)/2 as colour.
    Normals,
    /// Reflectance.
    Albedo,
    /// Radiosity with the edges of the elements over it.
    Wireframe,
}

/// The views as people write them, for help texts and errors.
pub const VIEW_NAMES: &str = "radiosity, irradiance, direct, indirect, bounce=K, normals, albedo or wireframe";

impl View {
    /// True if the view shows direct light, alone or in a sum.
    pub fn shows_direct(self) -> bool {
        matches!(self, View::Radiosity | View::Irradiance | View::Wireframe | View::Direct | View::Bounce(0))
    }

    /// The irradiance [W/m²] at the vertices that the view shows, without what is computed at the shown points; empty
    /// for views that show none.
    ///
    /// # Errors
    /// A bounce that the solution does not have.
    pub fn field(self, solution: &Solution, reconstruction: Reconstruction) -> Result<Cow<'_, [Vec3]>, String> {
        if reconstruction != Reconstruction::Vertex && self.shows_direct() {
            let is_direct_alone = matches!(self, View::Direct | View::Bounce(_));
            return Ok(if is_direct_alone { Cow::default() } else { solution.indirect().into() });
        }
        match self {
            View::Radiosity | View::Irradiance | View::Wireframe => Ok(solution.total().into()),
            View::Direct => Ok(solution.direct().into()),
            View::Indirect => Ok(solution.indirect().into()),
            View::Bounce(bounce) => {
                let values = solution.bounces.get(bounce);
                values.map(|values| values.as_slice().into()).ok_or_else(|| {
                    format!("the solution has bounces 0 to {}, not {bounce}", solution.bounces.len().saturating_sub(1))
                })
            }
            View::Normals | View::Albedo => Ok(Cow::default()),
        }
    }

    /// The irradiance [W/m²] at all texels of a lightmap's pages that the view shows; empty for views that show none.
    ///
    /// # Errors
    /// A bounce after the first: a lightmap knows direct light and all light.
    pub fn texels(self, solution: &LightmapSolution) -> Result<Cow<'_, [Vec3]>, String> {
        let LightmapSolution { direct, total, .. } = solution;
        match self {
            View::Radiosity | View::Irradiance | View::Wireframe => Ok(total.into()),
            View::Direct | View::Bounce(0) => Ok(direct.into()),
            View::Indirect => {
                Ok(total.iter().zip(direct).map(|(all, direct)| (*all - *direct).max(Vec3::ZERO)).collect())
            }
            View::Bounce(bounce) => Err(format!("a lightmap keeps direct and all light, not bounce {bounce}")),
            View::Normals | View::Albedo => Ok(Cow::default()),
        }
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || format!("unknown view `{text}`; it can be {VIEW_NAMES}");
        match text {
            "radiosity" => Ok(View::Radiosity),
            "irradiance" => Ok(View::Irradiance),
            "direct" => Ok(View::Direct),
            "indirect" => Ok(View::Indirect),
            "normals" => Ok(View::Normals),
            "albedo" => Ok(View::Albedo),
            "wireframe" => Ok(View::Wireframe),
            _ => {
                let bounce = text.strip_prefix("bounce=").ok_or_else(unknown)?;
                bounce.parse().map(View::Bounce).map_err(|_| unknown())
            }
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            View::Radiosity => formatter.write_str("radiosity"),
            View::Irradiance => formatter.write_str("irradiance"),
            View::Direct => formatter.write_str("direct"),
            View::Indirect => formatter.write_str("indirect"),
            View::Bounce(bounce) => write!(formatter, "bounce={bounce}"),
            View::Normals => formatter.write_str("normals"),
            View::Albedo => formatter.write_str("albedo"),
            View::Wireframe => formatter.write_str("wireframe"),
        }
    }
}
