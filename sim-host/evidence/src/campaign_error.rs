//! Why a campaign against the flashed image has no result.

/// Why a run, or the campaign, has no result.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The board has stopped: a finding of the model.
    #[error(transparent)]
    Board(#[from] board::BoardError),
    /// The processor has.
    #[error(transparent)]
    Stopped(#[from] cortex_m4::Stop),
    /// It does not answer.
    #[error(transparent)]
    Link(#[from] link::link_error::LinkError),
    /// The scene is not valid.
    #[error(transparent)]
    Load(#[from] scene::load::LoadError),
    /// The scene has no drive, or its board is in use.
    #[error("the scene of the campaign has no board")]
    Scene,
    /// The image has no such symbol.
    #[error("the image has no symbol {0}")]
    Symbol(&'static str),
    /// It was ordered to drive, and does not.
    #[error("the board has not locked within {0:?}")]
    NoLock(std::time::Duration),
    /// The image cannot be made an update.
    #[error(transparent)]
    Pack(#[from] link::update_file::PackError),
    /// The board does not come to the phase.
    #[error("the board does not come to {0}")]
    NotThere(&'static str),
    /// The image cannot be read.
    #[error("the image cannot be read: {0}")]
    Io(#[from] std::io::Error),
}
