//! Errors of campaigns against the flashed image.

/// Reason why a run or a campaign has no result.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The model of the board has stopped with a finding.
    #[error(transparent)]
    Board(#[from] board::BoardError),
    /// The processor has stopped.
    #[error(transparent)]
    Stopped(#[from] cortex_m4::Stop),
    /// The board does not answer.
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
    /// The board does not drive after the order to run.
    #[error("the board has not locked within {0:?}")]
    NoLock(std::time::Duration),
    /// The image cannot be packed as an update.
    #[error(transparent)]
    Pack(#[from] link::update_file::PackError),
    /// The board does not reach a phase.
    #[error("the board does not reach {0}")]
    NotReached(&'static str),
    /// The image cannot be read.
    #[error("the image cannot be read: {0}")]
    Io(#[from] std::io::Error),
}
