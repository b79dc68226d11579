//! The command: arguments, one file per verb.
