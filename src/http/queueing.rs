//! Jobs put into the queue, as far as it has places and their tenant may.

use super::App;
use super::observation::Trace;
use super::problem::Problem;
use crate::jobs;
use crate::store::{Job, NewJob, Places, Submitted, Unkept};

impl App {
    /// Puts a job into the queue, of whose places its kind may take so many, together with the shape that came within its
    /// request, where one did.
    ///
    /// # Errors
    /// 429 where the tenant has as many jobs as it may; 503 where the queue is full; 404 where a shape the job needs was deleted meanwhile.
    pub(super) async fn queued(&self, job: &NewJob<'_>, shape: Option<Unkept>) -> Result<Job, Problem> {
        let (job, places) = (&self.traced(job), self.places(job.kind));
        let _turn = self.may_take(shape.as_ref().map_or(0, Unkept::bytes), 1).await?;
        let submitted = match shape {
            Some(shape) => self.store.submit_with(shape, job, places).await?,
            None => self.store.submit(job, places).await?,
        };
        Ok(*taken(submitted)?)
    }

    /// Puts jobs of one kind into the queue together: all or none.
    ///
    /// # Errors
    /// As of [`queued`](Self::queued).
    pub(super) async fn queued_together(&self, kind: &str, jobs: &[NewJob<'_>]) -> Result<Vec<Job>, Problem> {
        let jobs: Vec<NewJob> = jobs.iter().map(|job| self.traced(job)).collect();
        let _turn = self.may_take(0, jobs.len() as u64).await?;
        taken(self.store.submit_all(&jobs, self.places(kind)).await?)
    }

    /// How many jobs of one kind may wait together: what wants more at once never finds room.
    pub(super) fn most_together(&self, kind: &str) -> usize {
        let of_tenant = self.config.tenant_limits.queued_jobs.and_then(|most| usize::try_from(most).ok());
        self.places(kind).of_kind.min(of_tenant.unwrap_or(usize::MAX))
    }

    /// The job as part of the trace that the request is part of.
    fn traced<'a>(&'a self, job: &NewJob<'a>) -> NewJob<'a> {
        NewJob { trace: self.trace.as_ref().map(|Trace(trace)| &**trace), ..*job }
    }

    /// The places of the queue, and those of them that jobs of a kind may take.
    fn places(&self, kind: &str) -> Places {
        let queue = self.config.max_queue;
        Places { queue, of_kind: jobs::kind(kind).map_or(queue, |kind| kind.places(queue)) }
    }
}

/// What was taken into the queue.
///
/// # Errors
/// 503 where it is full; 404 where a shape was deleted meanwhile.
fn taken<T>(submitted: Submitted<T>) -> Result<T, Problem> {
    match submitted {
        Submitted::Taken(taken) => Ok(taken),
        Submitted::Full => Err(Problem::busy("the queue is full", 10)),
        Submitted::Gone => Err(Problem::not_found("shape of this id any more")),
    }
}
