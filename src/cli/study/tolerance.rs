//! `biprism analyse tolerance` and `biprism merge`.

use super::common::{StudiedPrism, lens, lens_words, prisms, write, write_into};
use super::trial_file::{TrialFile, read_whole};
use crate::analysis::tolerance::operand::Operand;
use crate::analysis::tolerance::probe::{Criterion, Probe};
use crate::analysis::tolerance::sensitivity::{Budgeted, sensitivities};
use crate::analysis::tolerance::trials::{Distribution, TrialPlan, trials};
use crate::cli::outcome::Outcome;
use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::tolerance_args::{DistributionArg, MergeArgs, ToleranceArgs};
use crate::error::Error;
use crate::progress::Observer;
use crate::report::identity;
use crate::report::study::document::StudyDocument;
use crate::report::study::tolerances::{self, NamedSensitivities};
use crate::report::study::trial_lines::{RunPrism, TRIALS_SCHEMA, TrialLine, TrialRun, line};
use crate::report::study::trials::document;
use serde_json::json;
use std::collections::BTreeMap;

/// Rings of the pupil of the spots.
const RINGS: usize = 16;
/// Trials between two writings: a second's work or so.
const CHUNK: usize = 256;
/// The file of all trials of a run.
const WHOLE: &str = "tolerance_trials.jsonl";

pub(crate) fn run(args: &ToleranceArgs) -> Result<Outcome, Error> {
    let budgets = once(&args.budget)?;
    let operands = if args.operand.is_empty() {
        Operand::ALL.map(|operand| (operand, operand.usual())).to_vec()
    } else {
        args.operand.clone()
    };
    let listed = |criterion: &Criterion| {
        args.criterion.is_empty()
            || args.criterion.contains(criterion)
            || budgets.iter().any(|b| b.criterion == *criterion)
    };
    let asked: Vec<Criterion> = Criterion::ALL.into_iter().filter(listed).collect();

    // Make the prisms, and say which errors they cannot have.
    let progress = Progress::new(0);
    let mut probes = Vec::new();
    for prism in prisms(&args.prisms, &progress)? {
        let probe = prism.named(Probe::new(&prism.judged.scene, lens(&args.lens), RINGS, args.lens.focus_mm))?;
        let lacks = operands.iter().filter(|(operand, _)| !operand.acts_on(&probe.scene.prism));
        let lacks: Vec<&str> = lacks.map(|(operand, _)| operand.name()).collect();
        if !lacks.is_empty() {
            let kind = probe.scene.prism.kind();
            output::stderr(&format!(
                "note: {}: a {kind} prism is left without {}",
                prism.judged.name,
                lacks.join(", ")
            ));
        }
        probes.push((prism, probe));
    }
    match args.trials {
        None => sensitivity(args, &probes, &operands, &asked, &budgets, &progress),
        Some(count) => {
            let plan = TrialPlan { operands, distribution: distribution(args), seed: args.seed, asked };
            random(args, &probes, &plan, count, &budgets, &progress)
        }
    }
}

/// Each criterion's budget, stated at most once.
fn once(budgets: &[Budgeted]) -> Result<Vec<Budgeted>, Error> {
    let twice = |k: usize| budgets[..k].iter().any(|b| b.criterion == budgets[k].criterion);
    match (0..budgets.len()).find(|k| twice(*k)) {
        None => Ok(budgets.to_vec()),
        Some(k) => {
            let rule = format!("{} is given more than once", budgets[k].criterion.key());
            Err(Error::new("--budget", rule, "give each criterion one budget"))
        }
    }
}

fn distribution(args: &ToleranceArgs) -> Distribution {
    match args.distribution {
        DistributionArg::Normal => Distribution::Normal,
        DistributionArg::Uniform => Distribution::Uniform,
    }
}

/// One error at a time.
fn sensitivity(
    args: &ToleranceArgs,
    probes: &[(StudiedPrism, Probe)],
    operands: &[(Operand, f64)],
    asked: &[Criterion],
    budgets: &[Budgeted],
    progress: &Progress,
) -> Result<Outcome, Error> {
    let mut found = Vec::new();
    for (prism, probe) in probes {
        let watch = progress.watch(&prism.judged.name);
        watch.stage_of("errors", operands.len());
        let right = probe.figures(&probe.scene, asked).map_err(|why| {
            let rule = format!("the prism without errors has no figure: {}", why.0);
            Error::new(&prism.judged.name, rule, "leave its criterion out with --criterion, or use a smaller --na")
        })?;
        let errors = sensitivities(probe, operands, asked, budgets, &|| watch.pixels(1));
        for error in &errors {
            for (sign, why) in
                ["+", "-"].iter().zip(error.figures.iter()).filter_map(|(s, f)| Some((s, f.as_ref().err()?)))
            {
                let of = format!(
                    "{}: {} {sign}{} {}",
                    prism.judged.name,
                    error.operand.name(),
                    error.amount,
                    error.operand.unit()
                );
                output::stderr(&format!("note: {of} has no figure: {}", why.0));
            }
        }
        found.push(NamedSensitivities { prism: prism.judged.name.clone(), right, errors });
    }
    let mut settings = lens_words(&args.lens);
    let kept: BTreeMap<&str, f64> = budgets.iter().map(|b| (b.criterion.key(), b.most)).collect();
    settings.insert("budgets".to_owned(), json!(kept));
    let (sheets, figures) = (tolerances::sheets(&found, asked, budgets), tolerances::figures(&found, asked));
    write(&args.prisms, &StudyDocument { name: "tolerance", settings, sheets, figures })
}

/// All errors at once, drawn at random.
fn random(
    args: &ToleranceArgs,
    probes: &[(StudiedPrism, Probe)],
    plan: &TrialPlan,
    count: u32,
    budgets: &[Budgeted],
    progress: &Progress,
) -> Result<Outcome, Error> {
    let instrument = |(prism, _): &(StudiedPrism, Probe)| RunPrism {
        name: prism.judged.name.clone(),
        instrument: identity::parts(&prism.judged.scene, &prism.system),
    };
    let run = TrialRun {
        schema: TRIALS_SCHEMA.to_owned(),
        prisms: probes.iter().map(instrument).collect(),
        operands: plan.operands.iter().map(|(operand, amount)| (operand.name().to_owned(), *amount)).collect(),
        distribution: plan.distribution.name().to_owned(),
        seed: plan.seed.to_string(),
        trials: count,
        criteria: plan.asked.iter().map(|criterion| criterion.key().to_owned()).collect(),
        lens: lens_words(&args.lens),
        shard: args.shard,
    };

    // Go on where an earlier run of the same plan was stopped.
    let name = args.shard.map_or(WHOLE.to_owned(), |[i, n]| format!("tolerance_trials_{i}_of_{n}.jsonl"));
    let mut file = TrialFile::open(&args.prisms.out, &name, &run)?;
    if !file.lines.is_empty() {
        output::stderr(&format!("{}: goes on after {} trials", file.path.display(), file.lines.len()));
    }
    for (k, (prism, probe)) in probes.iter().enumerate() {
        let missing = file.missing(&run, k);
        let watch = progress.watch(&prism.judged.name);
        watch.stage_of("trials", missing.len());
        for chunk in missing.chunks(CHUNK) {
            let judged = trials(probe, plan, chunk);
            file.append(judged.into_iter().map(|one| TrialLine::new(k, one)))?;
            watch.pixels(chunk.len());
        }
    }
    if args.shard.is_some() {
        output::stderr(&format!("wrote {}; make one of all parts with biprism merge", file.path.display()));
        return Ok(Outcome::Done);
    }
    output::stderr(&format!("wrote {}", file.path.display()));
    write(&args.prisms, &document(&run, &file.lines, budgets))
}

/// Makes one of the parts of a run.
pub(crate) fn merge(args: &MergeArgs) -> Result<Outcome, Error> {
    if let Some(figure) = args.figure.first() {
        let rule = format!("the files have trials, and no figure {figure}");
        return Err(Error::new("--figure", rule, "leave it out: it is for the lines of `biprism batch`"));
    }
    let budgets = once(&args.budget)?;
    let (run, lines) = read_whole(&args.files)?;
    let unknown = budgets.iter().find(|b| !run.criteria.iter().any(|key| key == b.criterion.key()));
    if let Some(budget) = unknown {
        let rule = format!("the trials have no {}", budget.criterion.key());
        return Err(Error::new("--budget", rule, format!("they have {}", run.criteria.join(", "))));
    }
    let path = &crate::cli::files::outputs(&args.out, &[WHOLE])?[0];
    crate::cli::files::text(path, &(line(&run) + &lines.iter().map(line).collect::<String>()))?;
    output::stderr(&format!("wrote {}", path.display()));
    write_into(&args.out, args.json, &document(&run, &lines, &budgets))
}
