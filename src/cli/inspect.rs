//! `inspect`: what a scene file holds, and what was repaired in it.

use std::fmt::Write as _;
use std::{path::PathBuf, sync::Arc};

use super::Outcome;
use crate::scene::inspect::{MaterialReport, SceneReport, report};
use crate::{
    files::loaded_scene::{read_scene, read_state},
    scene::LoadOptions,
    trace::Tracer,
    transport::facing::facing,
};

/// Read a scene and say what it holds: sizes, materials, emitters, textures, repairs.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The scene: an OBJ file, or `cornell` for the built-in Cornell box.
    pub scene: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub options: LoadOptions,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Reads the scene and prints its report.
///
/// # Errors
/// If the scene cannot be read.
pub fn run(arguments: &InspectArgs) -> anyhow::Result<Outcome> {
    let scene = Arc::new(read_scene(&arguments.scene, &arguments.options)?);
    let mut report = report(&scene);
    let (state, _) = read_state(&arguments.scene, None)?;
    let light = state.light.map(|light| light.to_local(&scene.frame));
    let tracer = Tracer::new(Arc::clone(&scene));
    report.warnings.extend(facing(&scene, &tracer, light.as_ref(), &arguments.options).map(|facing| facing.text));
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print!("{}", table(&report));
    }
    Ok(Outcome::Done)
}

/// The report for people.
fn table(report: &SceneReport) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_summary(&mut text, report)
        .and_then(|()| write_materials(&mut text, &report.materials))
        .and_then(|()| write_textures_and_warnings(&mut text, report));
    text
}

fn write_summary(text: &mut String, report: &SceneReport) -> std::fmt::Result {
    let point = |[x, y, z]: [f64; 3]| format!("{} {} {}", digits(x), digits(y), digits(z));
    let sides = if report.two_sided { " (two-sided)" } else { "" };
    writeln!(text, "{}", report.name)?;
    writeln!(text, "  triangles  {}{sides}", report.triangles)?;
    writeln!(text, "  vertices   {}", report.vertices)?;
    writeln!(text, "  bounds     {} .. {} m", point(report.minimum), point(report.maximum))?;
    writeln!(text, "  area       {} m²", digits(report.area))?;
    writeln!(text, "  hash       {}", report.hash)
}

fn write_materials(text: &mut String, materials: &[MaterialReport]) -> std::fmt::Result {
    let name_width = materials.iter().map(|material| material.name.chars().count()).max().unwrap_or(0).clamp(8, 32);
    let heading = "material";
    writeln!(text, "\n  {heading:name_width$}  triangles     area m²  mean reflectance     power W (red green blue)")?;
    for material in materials {
        let (name, [red, green, blue]) = (&material.name, material.mean_reflectance);
        let power = match material.emitted_power {
            [0.0, 0.0, 0.0] => String::from("-"),
            power => power.map(digits).join(" "),
        };
        let (triangles, area) = (material.triangles, digits(material.area));
        let texture = material.reflectance_texture.as_ref().map_or_else(String::new, |name| format!("  {name}"));
        let colour = format!("{red:.3} {green:.3} {blue:.3}");
        writeln!(text, "  {name:name_width$}  {triangles:9}  {area:>10}  {colour:19}  {power}{texture}")?;
    }
    Ok(())
}

fn write_textures_and_warnings(text: &mut String, report: &SceneReport) -> std::fmt::Result {
    for texture in &report.textures {
        writeln!(text, "  texture {} x {}  {}", texture.width, texture.height, texture.name)?;
    }
    if !report.warnings.is_empty() {
        writeln!(text)?;
    }
    for warning in &report.warnings {
        writeln!(text, "  warning: {warning}")?;
    }
    Ok(())
}

/// Six significant digits, in powers of ten where that is shorter.
fn digits(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e9).contains(&value.abs()) {
        return format!("{value:.5e}");
    }
    let before_point = value.abs().max(1e-4).log10().floor() as i32;
    format!("{value:.*}", usize::try_from(5 - before_point).unwrap_or(0).min(6))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::load_from_memory;

    const LAMP: &str = "newmtl lamp\nKd 0.25 0.5 0.75\nKe 1 2 0\n";

    #[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
    #[test]
    fn a_square_lamp_is_reported_with_its_area_and_power() {
        let obj = "v 0 0 0\nv 2 0 0\nv 2 0 -2\nv 0 0 -2\nusemtl lamp\nf 1 2 3 4\nl 1 2\n";
        let scene = load_from_memory("square", obj, LAMP, &LoadOptions::default()).unwrap();
        let report = report(&scene);
        assert_eq!(
            (report.triangles, report.vertices, report.minimum, report.maximum),
            (2, 4, [0.0, 0.0, -2.0], [2.0, 0.0, 0.0])
        );
        let lamp = &report.materials[0];
        assert_eq!((report.area, lamp.area, lamp.mean_reflectance), (4.0, 4.0, [0.25, 0.5, 0.75]));
        // Power of a diffuse emitter: π L A.
        let expected = [4.0, 8.0, 0.0].map(|factor| factor * std::f64::consts::PI);
        assert_eq!(lamp.emitted_power, expected);
        let text = table(&report);
        assert!(text.contains("area       4.00000 m²"), "{text}");
        assert!(text.contains("12.5664 25.1327 0.000000"), "{text}");
        assert!(text.contains("warning: ignored 1 line element, in line 7"), "{text}");
        assert!(serde_json::to_string(&report).unwrap().contains("\"emitted_power\":[12.56637"));
    }

    #[test]
    fn numbers_keep_six_digits() {
        for (value, text) in [
            (0.0, "0.000000"),
            (-17.4049, "-17.4049"),
            (7502.93, "7502.93"),
            (1e-7, "1.00000e-7"),
            (2.5e12, "2.50000e12"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
