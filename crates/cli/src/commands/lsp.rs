//! `qrm lsp`

use clap::Args;
use lsp_server::Connection;
use qrm_core::Model;

use crate::error::Error;
use crate::lsp::{capabilities, serve};

#[derive(Args)]
pub(crate) struct Options {
    /// Accepted for editors that name the transport; there is no other one
    #[arg(long)]
    stdio: bool,
}

/// Serves an editor by the language server protocol, on standard input and output, until it ends.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let Options { stdio: _ } = options;
    let broken = |reason: String| Error::run(format!("the connection to the editor broke off: {reason}"));
    let (connection, threads) = Connection::stdio();
    connection.initialize(capabilities()).map_err(|e| broken(e.to_string()))?;
    serve(models, &connection).map_err(|e| broken(e.to_string()))?;
    drop(connection);
    threads.join().map_err(|e| broken(e.to_string()))
}
