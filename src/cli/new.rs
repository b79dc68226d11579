//! `biprism new`: a scene to begin with, from flags or questions.

use super::new_args::{NewArgs, PrismArg};
use super::outcome::Outcome;
use super::{files, output};
use crate::design::starter::StarterScene;
use crate::error::Error;
use crate::system;
use clap::ValueEnum;
use std::io::BufRead;
use std::path::Path;

pub(super) fn run(args: &NewArgs) -> Result<Outcome, Error> {
    // Refuse to lose a file before anything is asked.
    let to_stdout = files::is_stdin(&args.path);
    if !to_stdout && args.path.exists() {
        let help = "name a file that is not there yet, or remove it first";
        return Err(Error::new(args.path.display(), "there is such a file, and it is not written over", help));
    }

    // Take what is given, ask for the rest, and write the text.
    let starter = starter(args, &mut std::io::stdin().lock())?;
    let text = starter.text()?;
    let wrong = |problem: Error| {
        let help = format!("{}; change what was given of sensor, lens, prism or distance", problem.help);
        Error::new("these values", format!("they make no scene: {}", problem.rule), help)
    };
    let scene = crate::scene::parse(&text, "the scene", None).map_err(wrong)?;
    let built = system::build(&scene).map_err(wrong)?;
    if to_stdout {
        output::stdout(&text)?;
    } else {
        files::folder_of(&args.path)?;
        files::text(&args.path, &text)?;
        output::stderr(&format!("wrote {}", args.path.display()));
    }

    // Say what may be wrong with it, and how to go on.
    system::doubts(&scene, &built).iter().for_each(|doubt| output::stderr(&format!("note: {doubt}")));
    if !to_stdout {
        let name = args.path.display();
        output::stderr(&format!(
            "next: `biprism check {name}` says what it holds, `biprism compare {name}` judges its prism, `biprism render {name} \
             --out picture.png` takes its picture"
        ));
    }
    Ok(Outcome::Done)
}

/// The scene by flags, answers to `input` where `--ask` is given, and the design paper's instrument.
fn starter(args: &NewArgs, input: &mut dyn BufRead) -> Result<StarterScene, Error> {
    let mut asked = Questions { input, ask: args.ask };
    let whole = |given: Option<u32>| given.map(f64::from);
    let width = asked.number("columns of the sensor, px", whole(args.width_px), 1920.0, [2.0, 65536.0])?;
    let height = asked.number("rows of the sensor, px", whole(args.height_px), 1080.0, [2.0, 65536.0])?;
    let pitch_um = asked.number("pixel pitch, um", args.pixel_um, 5.5, [1e-3, 1e4])?;
    let focal_mm = asked.number("focal length of the lens, mm", args.focal_mm, 35.0, [1e-3, 1e6])?;
    let distance_mm = asked.number("distance of the board, mm", args.distance_mm, 1000.0, [1e-3, 1e9])?;
    let prism = asked.prism(args.prism)?;
    let glass = prism != PrismArg::None;
    let mut of_glass = |words: &str, given: Option<f64>, proposed: f64, within: [f64; 2]| {
        if glass { asked.number(words, given, proposed, within) } else { Ok(given.unwrap_or(proposed)) }
    };
    let index = of_glass("refractive index of the glass", args.index, 1.48, [1.0, 5.0])?;
    let ridge_mm = of_glass("distance of the prism's ridge from the camera, mm", args.ridge_mm, 78.472, [1e-3, 1e6])?;
    Ok(StarterScene {
        name: name(&args.path),
        size_px: [width as usize, height as usize],
        pitch_um,
        focal_mm,
        distance_mm,
        ridge_mm,
        index,
        prism: prism.into(),
    })
}

/// The name of a scene by its file.
fn name(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    let named: String = stem.chars().map(|c| if allowed(c) { c } else { '_' }).collect();
    let named = named.trim_start_matches('-');
    if named.chars().all(|c| c == '_') { "scene".to_owned() } else { named.to_owned() }
}

/// Questions to a person, who may answer with an empty line.
struct Questions<'a> {
    input: &'a mut dyn BufRead,
    ask: bool,
}

impl Questions<'_> {
    /// The answer to a question; `None` for an empty line, and at the end of the answers.
    fn answer(&mut self, words: &str) -> Result<Option<String>, Error> {
        output::stderr(words);
        let mut line = String::new();
        self.input
            .read_line(&mut line)
            .map_err(|error| Error::new("stdin", format!("cannot be read: {error}"), "answer in one line of text"))?;
        let answer = line.trim();
        Ok((!answer.is_empty()).then(|| answer.to_owned()))
    }

    fn number(&mut self, words: &str, given: Option<f64>, proposed: f64, [low, high]: [f64; 2]) -> Result<f64, Error> {
        let answer = match given {
            Some(_) => None,
            None if !self.ask => None,
            None => self.answer(&format!("{words} [{proposed}]?"))?,
        };
        let value = match (given, answer) {
            (Some(value), _) => value,
            (None, None) => proposed,
            (None, Some(text)) => text.parse().map_err(|_| {
                Error::new("the answer", format!("`{text}` is no number"), format!("answer {words} as in {proposed}"))
            })?,
        };
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let rule = format!("{value:e} is not within {low} .. {high}");
        Err(Error::new(words, rule, format!("give a number such as {proposed}")))
    }

    fn prism(&mut self, given: Option<PrismArg>) -> Result<PrismArg, Error> {
        if given.is_some() || !self.ask {
            return Ok(given.unwrap_or(PrismArg::Exact));
        }
        let Some(text) = self.answer("the prism: exact, freeform, flat or none [exact]?")? else {
            return Ok(PrismArg::Exact);
        };
        PrismArg::from_str(&text, true).map_err(|_| {
            Error::new("the answer", format!("`{text}` is no prism"), "answer exact, freeform, flat or none")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::starter::StarterPrism;
    use clap::Parser;

    fn args(words: &[&str]) -> NewArgs {
        let all = ["biprism", "new", "mine.toml"].iter().chain(words);
        match crate::cli::args::Args::parse_from(all).verb {
            Some(crate::cli::args::Verb::New(args)) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn answers_fill_what_no_flag_gives() {
        // Columns, rows, pitch, distance, prism, index, ridge: the focal length has a flag.
        let answers = "1280\n\n4.8\n600\nFLAT\n\n60\n";
        let found = starter(&args(&["--ask", "--focal-mm", "16"]), &mut answers.as_bytes()).unwrap();
        let wanted = StarterScene {
            name: "mine".to_owned(),
            size_px: [1280, 1080],
            pitch_um: 4.8,
            focal_mm: 16.0,
            distance_mm: 600.0,
            ridge_mm: 60.0,
            index: 1.48,
            prism: StarterPrism::Flat,
        };
        assert_eq!(found, wanted);
        let wrong = starter(&args(&["--ask"]), &mut "many\n".as_bytes()).unwrap_err();
        assert!(wrong.rule.contains("`many` is no number"), "{wrong:?}");
    }

    #[test]
    fn nothing_is_asked_without_being_told_to() {
        let found = starter(&args(&["--prism", "none"]), &mut "never read".as_bytes()).unwrap();
        assert_eq!((found.size_px, found.prism), ([1920, 1080], StarterPrism::None));
    }
}
