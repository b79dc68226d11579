//! `biprism batch`: a verb for many scenes, a line a job, on as many machines as there are.

mod job_file;
mod jobs;
mod join;
mod run;
mod verb;

pub(super) use join::{is_batch, join};
pub(super) use run::run;
pub use verb::{designed, figures};
