//! What one tenant may take of what all share.

use std::num::NonZeroU32;
use std::time::Duration;

use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use governor::clock::{Clock, DefaultClock};
use governor::middleware::StateInformationMiddleware;
use governor::state::keyed::DefaultKeyedStateStore;
use governor::{Quota, RateLimiter};

use super::App;
use super::problem::Problem;
use crate::access::Tenant;
use crate::store::Turn;

/// What a tenant may take; where nothing is said, as much as there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TenantLimits {
    /// As many may come at once, and as many in every second; counted by each server for itself.
    pub requests_per_second: Option<NonZeroU32>,
    /// Requests under way at one time, until their answers are read; counted by each server for itself.
    pub open_requests: Option<u64>,
    /// Jobs that wait.
    pub queued_jobs: Option<u64>,
    /// Bytes of uploads and results.
    pub stored_bytes: Option<u64>,
    /// Processor time of jobs within an hour; jobs that run are not broken off.
    pub cpu_per_hour: Option<Duration>,
}

/// Counts the requests of every tenant.
pub struct Pace {
    per_second: NonZeroU32,
    limiter: RateLimiter<Tenant, DefaultKeyedStateStore<Tenant>, DefaultClock, StateInformationMiddleware>,
}

/// The headers of <https://datatracker.ietf.org/doc/draft-ietf-httpapi-ratelimit-headers/>.
const POLICY: HeaderName = HeaderName::from_static("ratelimit-policy");
const LIMIT: HeaderName = HeaderName::from_static("ratelimit");

/// Seconds after which to ask again whether something of a tenant's has ended or grown old.
const UNTIL_THERE_IS_ROOM: u32 = 30;

impl Pace {
    pub fn new(per_second: NonZeroU32) -> Pace {
        Pace::of(Quota::per_second(per_second), per_second)
    }

    fn of(quota: Quota, per_second: NonZeroU32) -> Pace {
        Pace { per_second, limiter: RateLimiter::keyed(quota).with_middleware() }
    }

    /// Counts a request: what is to be told of those that are left and, where there are none now, after how many seconds there
    /// are.
    pub fn count(&self, tenant: &Tenant) -> (HeaderMap, Option<u32>) {
        match self.limiter.check_key(tenant) {
            Ok(state) => (self.headers(state.remaining_burst_capacity(), 1), None),
            Err(until) => {
                let wait = until.wait_time_from(self.limiter.clock().now());
                let seconds = u32::try_from(wait.as_secs()).unwrap_or(u32::MAX).saturating_add(1);
                (self.headers(0, seconds), Some(seconds))
            }
        }
    }

    /// 429: a tenant's requests come faster than this.
    pub fn exceeded(&self, seconds: u32) -> Problem {
        Problem::too_many(format!("{} requests a second are taken from one tenant", self.per_second), seconds)
    }

    fn headers(&self, left: u32, seconds: u32) -> HeaderMap {
        let policy = format!("\"requests\";q={};w=1", self.per_second);
        let limit = format!("\"requests\";r={left};t={seconds}");
        let headers = [(POLICY, policy), (LIMIT, limit)];
        headers.into_iter().filter_map(|(name, value)| Some((name, HeaderValue::try_from(value).ok()?))).collect()
    }
}

impl App {
    /// Ok where the tenant may have so many bytes more kept and so many jobs more wait, as long as the turn is held.
    ///
    /// # Errors
    /// 429 where it may not.
    pub(super) async fn may_take(&self, bytes: usize, jobs: u64) -> Result<Option<Turn>, Problem> {
        let TenantLimits { queued_jobs, stored_bytes, cpu_per_hour, .. } = self.config.tenant_limits;
        // Only what is taken is looked up.
        let (queued_jobs, cpu_per_hour) = (queued_jobs.filter(|_| jobs > 0), cpu_per_hour.filter(|_| jobs > 0));
        let stored_bytes = stored_bytes.filter(|_| bytes > 0);
        if (queued_jobs, stored_bytes, cpu_per_hour) == (None, None, None) {
            return Ok(None);
        }
        let turn = self.store.turn(TAKING).await;
        let usage = self.store.usage().await?;
        let spent = |detail: String| Err(Problem::too_many(detail, UNTIL_THERE_IS_ROOM));
        if let Some(most) = queued_jobs.filter(|most| usage.queued.saturating_add(jobs) > *most) {
            return spent(format!("up to {most} jobs of one tenant wait"));
        }
        if let Some(most) = stored_bytes.filter(|most| usage.bytes.saturating_add(bytes as u64) > *most) {
            let kept = usage.bytes;
            let detail = format!("up to {most} bytes of one tenant are kept, {kept} are: delete what is not needed");
            // By waiting alone nothing goes.
            return Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, detail));
        }
        if let Some(most) = cpu_per_hour.filter(|most| usage.cpu >= *most) {
            let seconds = most.as_secs();
            return spent(format!("jobs of one tenant take up to {seconds} s of processor time in an hour"));
        }
        Ok(Some(turn))
    }
}

/// The turn of those of a tenant's requests that take what is limited: with a space, it is no key of a client's.
const TAKING: &str = "what is limited";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tenant_has_a_pace_of_its_own() {
        // So slow that none is added while the test runs.
        let two = NonZeroU32::new(2).unwrap();
        let pace = Pace::of(Quota::per_hour(two), two);
        let [one, other]: [Tenant; 2] = ["one", "other"].map(|name| name.parse().unwrap());
        let told = |headers: &HeaderMap| headers[LIMIT].to_str().unwrap().to_owned();
        let (headers, wait) = pace.count(&one);
        assert_eq!((told(&headers).as_str(), wait), ("\"requests\";r=1;t=1", None));
        assert_eq!(headers[POLICY], "\"requests\";q=2;w=1");
        assert_eq!(told(&pace.count(&one).0), "\"requests\";r=0;t=1");
        let (headers, wait) = pace.count(&one);
        let wait = wait.unwrap();
        assert!((1..=1800).contains(&wait), "{wait}");
        assert_eq!(told(&headers), format!("\"requests\";r=0;t={wait}"));
        assert_eq!((pace.exceeded(wait).status, pace.exceeded(wait).retry_after), (429, Some(wait)));
        assert_eq!(pace.count(&other).1, None);
    }
}
