//! `biprism dataset`: many pictures of one instrument, with what is true of each.

mod manifest_file;
mod places;
mod run;
mod workers;

pub(super) use run::run;
