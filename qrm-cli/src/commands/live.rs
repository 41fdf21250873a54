//! `qrm live`

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use qrm_core::Model;
use qrm_scene::source::read_text;
use qrm_view::animation::{SimulatorPage, simulator_page};

use crate::error::Error;
use crate::live::{Feed, Server, Session};
use crate::options::SceneName;
use crate::output::print;
use crate::page_data;
use crate::progress::{interrupted, watch_interrupts};
use crate::scenes::{Named, path_of};

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
    let named = options.scene.named(models)?;
    let file = match &named {
        Named::File(path) => {
            read_text(path)?;
            Some(path.clone())
        }
        Named::Model(model) => Some(PathBuf::from(path_of(model.description))).filter(|path| path.is_file()),
    };
    let title = file.as_ref().map_or_else(|| options.scene.scene.clone(), |path| path.display().to_string());
    let feed = Arc::new(Feed::default());
    let page = simulator_page(&SimulatorPage {
        title: &title,
        doc: "",
        command: &options.scene.scene,
        module: &page_data::module(),
        scene: None,
    });
    let server = Server::new(options.port, page, Arc::clone(&feed), file.clone())?;
    let address = server.address();
    let followed = file.as_ref().map_or_else(String::new, |path| format!(", and follows {}", path.display()));
    print(&format!("{title} is at {address}{followed}; end by Ctrl-C"));
    watch_interrupts();
    std::thread::spawn(move || server.serve());
    if !options.no_open && open::that_detached(&address).is_err() {
        print("no browser could be opened: open the address yourself");
    }
    match (file, named) {
        (None, Named::Model(model)) => {
            Session::new(models, path_of(model.description).into(), feed).show_text(model.description.source);
            while !interrupted() {
                std::thread::sleep(std::time::Duration::from_millis(100));
            }
        }
        (file, _) => Session::new(models, file.unwrap_or_default(), feed).follow(),
    }
    Ok(())
}
