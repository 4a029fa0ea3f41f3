//! What handlers have at hand, for tests.

use metrics_exporter_prometheus::PrometheusBuilder;
use tokio_util::sync::CancellationToken;

use super::{App, Config};
use crate::store::Store;

/// An app over this store, whose measures nobody looks at and which nobody stops.
pub fn app(store: Store, config: Config) -> App {
    let measures = PrometheusBuilder::new().build_recorder().handle();
    App::new(store, config, measures, CancellationToken::new())
}
