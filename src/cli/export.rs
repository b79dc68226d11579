//! `biprism export`: files for other programs.

use super::export_args::{BODY_TOLERANCE_MM, ExportArgs, ExportFormat, GRID_TOLERANCE_MM};
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::analysis::dataset::SetCameras;
use crate::design::text::{GridSagText, scene_grid_sag};
use crate::effect::Effects;
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::grid_sag::write_grid_sag;
use crate::io::inputs::check_outputs;
use crate::io::solid::SolidFormat;
use crate::report::dataset::cameras_text;
use crate::report::export::grid_sag::SampledSurface;
use crate::report::export::optiland::OptilandPrism;
use crate::report::export::zemax_extended::ExtendedPrism;
use crate::report::picture::{PictureFile, render_to_files};
use crate::scene::{GlassSpec, Scene};
use crate::surface::face::Face;
use crate::system::solid::solid_within;
use crate::system::{self, Side, System};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Degree of the polynomials that are fitted to a grid of a surface that is none.
const FITTED_DEGREE: usize = 12;

/// A file that was written, with its figures: key, value, and unit for people.
struct Exported {
    path: PathBuf,
    figures: Vec<(&'static str, Value)>,
}

/// What an export is made of.
struct Export<'a> {
    args: &'a ExportArgs,
    scene: Scene,
    /// With all effects where a format is of the picture; else the prism as it is meant to be, behind the lens of the scene.
    system: System,
}

pub(super) fn run(args: &ExportArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene, &args.values)?;
    let paths = paths(args)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let system = files::named(&args.scene, instrument(&scene, args.format))?;
    let export = Export { args, scene, system };
    progress.begin(&export.scene.name, "export");
    let exported = files::named(&args.scene, export.written(&paths, &progress))?;
    drop(progress);
    output::stdout(&if args.json { json(&export.scene, args, &exported) } else { words(&exported) })?;
    exported.iter().for_each(|file| output::stderr(&format!("wrote {}", file.path.display())));
    Ok(Outcome::Done)
}

fn instrument(scene: &Scene, format: ExportFormat) -> Result<System, Error> {
    if matches!(format, ExportFormat::CamerasYml | ExportFormat::Npy) {
        return system::build(scene);
    }
    let lens = Effects { lens: scene.effects.lens, ..Effects::default() };
    Ok(system::ideal(scene)?.with_effects(&lens))
}

/// The files to be written, none of which may be one that was read.
fn paths(args: &ExportArgs) -> Result<Vec<PathBuf>, Error> {
    let names: &[&str] = match args.format {
        ExportFormat::Optiland => &["left.json", "right.json"],
        ExportFormat::ZemaxGrid => &["front.dat", "back.dat", "prism.toml"],
        ExportFormat::ZemaxExtended => &["zemax_extended.txt"],
        ExportFormat::Stl => &["prism.stl"],
        ExportFormat::Ply => &["prism.ply"],
        ExportFormat::Obj => &["prism.obj"],
        ExportFormat::CamerasYml => &["cameras.yml"],
        ExportFormat::Npy => &["truth.npy"],
    };
    let strays = body(args.format).is_some() || args.format == ExportFormat::ZemaxGrid;
    if args.tolerance_mm.is_some() && !strays {
        let help = "leave it out, or take a body or zemax-grid";
        return Err(Error::new("--tolerance-mm", "what is written strays from nothing", help));
    }
    let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match (names, ending(&args.out)) {
        ([name], Some(found)) if !args.out.is_dir() => {
            let wanted = ending(Path::new(name)).unwrap_or_default();
            if found != wanted {
                let rule = format!("the extension is {found:?}, and that of this format is {wanted:?}");
                return Err(Error::new(args.out.display(), rule, "name a file that ends so, or a folder"));
            }
            checked(vec![args.out.clone()])
        }
        _ => checked(names.iter().map(|name| args.out.join(name)).collect()),
    }
}

fn checked(paths: Vec<PathBuf>) -> Result<Vec<PathBuf>, Error> {
    check_outputs(&paths)?;
    Ok(paths)
}

/// Which body a format is, if it is one.
fn body(format: ExportFormat) -> Option<SolidFormat> {
    match format {
        ExportFormat::Stl => Some(SolidFormat::Stl),
        ExportFormat::Ply => Some(SolidFormat::Ply),
        ExportFormat::Obj => Some(SolidFormat::Obj),
        _ => None,
    }
}

impl Export<'_> {
    fn written(&self, paths: &[PathBuf], progress: &Progress) -> Result<Vec<Exported>, Error> {
        match self.args.format {
            ExportFormat::Optiland => self.optiland(paths),
            ExportFormat::ZemaxGrid => self.grid_sag(paths),
            ExportFormat::ZemaxExtended => self.extended(&paths[0]),
            ExportFormat::CamerasYml => self.cameras(&paths[0]),
            ExportFormat::Npy => self.truth(&paths[0], progress),
            ExportFormat::Stl => self.solid(&paths[0], SolidFormat::Stl),
            ExportFormat::Ply => self.solid(&paths[0], SolidFormat::Ply),
            ExportFormat::Obj => self.solid(&paths[0], SolidFormat::Obj),
        }
    }

    fn solid(&self, path: &Path, format: SolidFormat) -> Result<Vec<Exported>, Error> {
        let body = solid_within(&self.system, self.args.tolerance_mm.unwrap_or(BODY_TOLERANCE_MM))?;
        files::folder_of(path)?;
        format.write(path, &body.solid)?;
        let figures = vec![
            ("points", body.solid.points_mm.len().into()),
            ("triangles", body.solid.triangles.len().into()),
            ("volume_mm3", body.solid.volume_mm3().into()),
            ("chord_mm", body.chord_mm.into()),
        ];
        Ok(vec![Exported { path: path.to_owned(), figures }])
    }

    fn grid_sag(&self, paths: &[PathBuf]) -> Result<Vec<Exported>, Error> {
        let tolerance_mm = self.args.tolerance_mm.unwrap_or(GRID_TOLERANCE_MM);
        let sampled = [
            SampledSurface::new(&self.system, Face::Front, tolerance_mm)?,
            SampledSurface::new(&self.system, Face::Back, tolerance_mm)?,
        ];
        let mut exported = Vec::new();
        files::folder_of(&paths[0])?;
        for (path, surface) in paths.iter().zip(&sampled) {
            write_atomically(path, |out| write_grid_sag(&surface.grid, &surface.points, out))?;
            let figures = vec![
                ("size", json!(surface.grid.size)),
                ("step_mm", json!(surface.grid.step_mm.to_array())),
                ("points", surface.points.iter().flatten().count().into()),
                ("vertex_mm", json!(surface.vertex_mm)),
                ("interpolation_mm", json!(surface.interpolation_mm)),
            ];
            exported.push(Exported { path: path.clone(), figures });
        }
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let [front, back] = [0, 1].map(|k: usize| GridSagText {
            file: name(&paths[k]),
            degree: sampled[k].degree.unwrap_or(FITTED_DEGREE),
            vertex_mm: sampled[k].vertex_mm,
        });
        files::text(&paths[2], &scene_grid_sag(&front, &back, &self.glass()))?;
        exported.push(Exported { path: paths[2].clone(), figures: Vec::new() });
        Ok(exported)
    }

    /// The glass, with all that is known of the prism besides its surfaces.
    fn glass(&self) -> GlassSpec {
        let stated = self.scene.prism.body().copied().unwrap_or(GlassSpec::new(1.0, 1.0));
        let law = stated.law.or_else(|| self.system.designed().and_then(|prism| prism.law().copied()));
        GlassSpec { solid: Some(self.scene.prism.is_solid()), law, ..stated }
    }

    fn extended(&self, path: &Path) -> Result<Vec<Exported>, Error> {
        let prism = ExtendedPrism::new(&self.system)?;
        files::folder_of(path)?;
        files::text(path, &prism.text(&self.scene.name))?;
        let [front, back] = &prism.surfaces;
        let both = |of: fn(&_) -> f64| json!([of(front), of(back)]);
        let figures = vec![
            ("terms", json!([front.terms.len(), back.terms.len()])),
            ("vertex_mm", both(|surface| surface.vertex_mm)),
            ("radius_mm", both(|surface| surface.radius_mm)),
            ("departure_mm", both(|surface| surface.departure_mm)),
        ];
        Ok(vec![Exported { path: path.to_owned(), figures }])
    }

    fn optiland(&self, paths: &[PathBuf]) -> Result<Vec<Exported>, Error> {
        let prism = OptilandPrism::new(&self.system)?;
        let file = |side: Side, half: &str| {
            let name = format!("{}, {half} half", self.scene.name);
            prism.json(side, &name, self.glass().wavelength_nm)
        };
        let halves = [file(Side::Left, "left")?, file(Side::Right, "right")?];
        files::folder_of(&paths[0])?;
        for (path, half) in paths.iter().zip(&halves) {
            files::text(path, &format!("{half:#}\n"))?;
        }
        Ok(paths.iter().map(|path| Exported { path: path.clone(), figures: Vec::new() }).collect())
    }

    fn cameras(&self, path: &Path) -> Result<Vec<Exported>, Error> {
        let cameras = SetCameras::of(&self.system, &self.scene.analysis.depths_mm).map_err(|why| {
            Error::new("the virtual cameras", why.reason(), "`biprism compare` fits pinholes to what the halves see")
        })?;
        files::folder_of(path)?;
        files::text(path, &cameras_text(&cameras))?;
        let figures = vec![("baseline_mm", cameras.baseline_mm().into())];
        Ok(vec![Exported { path: path.to_owned(), figures }])
    }

    fn truth(&self, path: &Path, progress: &Progress) -> Result<Vec<Exported>, Error> {
        let picture = PictureFile::plain(path.to_owned());
        files::folder_of(path)?;
        render_to_files(&[picture], &self.scene, &self.system, &progress.watch(&self.scene.name))?;
        let figures = vec![("size_px", json!([self.scene.camera.width_px, self.scene.camera.height_px]))];
        Ok(vec![Exported { path: path.to_owned(), figures }])
    }
}

fn json(scene: &Scene, args: &ExportArgs, exported: &[Exported]) -> String {
    let file = |file: &Exported| {
        let figures = file.figures.iter().map(|(key, value)| ((*key).to_owned(), value.clone()));
        let path = ("path".to_owned(), Value::from(file.path.display().to_string()));
        Value::Object(std::iter::once(path).chain(figures).collect::<Map<String, Value>>())
    };
    let format = clap::ValueEnum::to_possible_value(&args.format).map(|value| value.get_name().to_owned());
    let files: Vec<Value> = exported.iter().map(file).collect();
    format!("{:#}\n", json!({"scene": scene.name, "format": format, "files": files}))
}

/// The figures for a person.
fn words(exported: &[Exported]) -> String {
    let line = |file: &Exported| {
        let figures = file.figures.iter().map(|(key, value)| {
            let value = short(value);
            match key.split_once("_mm") {
                Some((name, "3")) => format!("{name} {value} mm^3"),
                Some((name, _)) => format!("{name} {value} mm"),
                None => format!("{key} {value}"),
            }
        });
        format!("{}  {}\n", file.path.display(), figures.collect::<Vec<_>>().join(", "))
    };
    exported.iter().filter(|file| !file.figures.is_empty()).map(line).collect()
}

/// A figure of some digits, or several with blanks between them.
fn short(value: &Value) -> String {
    match value {
        Value::Array(values) => values.iter().map(short).collect::<Vec<_>>().join(" "),
        Value::Number(number) => match number.as_f64() {
            Some(figure) if number.is_f64() && (figure == 0.0 || figure.abs() >= 1e-3) => format!("{figure:.4}"),
            Some(figure) if number.is_f64() => format!("{figure:.1e}"),
            _ => value.to_string(),
        },
        _ => value.to_string(),
    }
}
