//! A scene in a browser that follows the scene's file.

mod derivation_key;
mod edit;
mod editor;
mod feed;
mod file_watcher;
mod http;
mod server;
mod session;
mod write_back;

pub(crate) use feed::Feed;
pub(crate) use server::Server;
pub(crate) use session::Session;
