//! `qrm live`

use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use clap::Args;
use qrm_core::Model;
use qrm_scene::source::read_text;
use qrm_view::animation::{SimulatorPage, simulator_page};

use crate::error::Error;
use crate::live::{Feed, Server, Session};
use crate::options::SceneName;
use crate::output::{print, shell_word};
use crate::packing;
use crate::progress::{interrupted, watch_interrupts};
use crate::scenes::{SceneSource, path_of};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// Port of the loopback interface [default: one that is free]
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Open no browser, only print the address
    #[arg(long)]
    no_open: bool,
}

/// Serves a page that follows a scene file.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let source = followed(options.scene.source(models)?);
    let (title, file) = match &source {
        SceneSource::File(path) => {
            read_text(path)?;
            (path.display().to_string(), Some(path.clone()))
        }
        SceneSource::Model(model) => (model.description.name.to_owned(), None),
    };
    let feed = Arc::new(Feed::default());
    let page = SimulatorPage {
        title: &title,
        doc: "",
        command: &shell_word(&title),
        is_writable: file.is_some(),
        module: &packing::module(),
        scene: None,
    };
    let page = simulator_page(&page, packing::compressed)?;
    let server = Server::new(options.port, page, Arc::clone(&feed), file)?;
    let launch_address = if options.no_open { None } else { Some(server.launch_address()?) };
    let action = if matches!(source, SceneSource::File(_)) { "the page follows the file; " } else { "" };
    print(&format!("{title} is at {}\n{action}end by Ctrl-C", server.address()));
    watch_interrupts();
    let serving = thread::Builder::new()
        .spawn(move || server.serve())
        .map_err(|e| Error::run(format!("the server cannot be started: {e}")))?;
    if launch_address.is_some_and(|address| open::that_detached(address).is_err()) {
        print("no browser could be opened: open the address yourself");
    }
    match source {
        SceneSource::File(path) => Session::new(models, path, feed).follow(|| serving.is_finished()),
        SceneSource::Model(model) => {
            Session::new(models, path_of(model.description).into(), feed).show_text(model.description.source);
            while !interrupted() && !serving.is_finished() {
                thread::sleep(Duration::from_millis(100));
            }
        }
    }
    if serving.is_finished() { Err(Error::run("the server accepts no more connections")) } else { Ok(()) }
}

/// The source to follow: for a scene of the program, its file if present.
fn followed(source: SceneSource) -> SceneSource {
    match source {
        SceneSource::Model(model) if Path::new(&path_of(model.description)).is_file() => {
            SceneSource::File(path_of(model.description).into())
        }
        source => source,
    }
}
