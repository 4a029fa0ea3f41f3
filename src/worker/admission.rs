use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::store::{Lease, Room};

/// Which jobs run beside each other on this node: as many as fit its memory together, and a suspect by itself.
pub(super) struct Admission {
    /// Bytes of memory for all jobs together; one that takes more runs alone.
    memory: u64,
    running: Mutex<Running>,
}

#[derive(Default)]
struct Running {
    jobs: usize,
    memory: u64,
    by_suspect: bool,
}

/// The room a job takes; given back when it is dropped.
pub(super) struct Admitted {
    admission: Arc<Admission>,
    memory: u64,
}

impl Admission {
    pub fn new(memory: u64) -> Admission {
        Admission { memory, running: Mutex::default() }
    }

    fn running(&self) -> MutexGuard<'_, Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is free for another job; nothing while a suspect runs.
    pub fn room(&self) -> Option<Room> {
        let running = self.running();
        let room = Room { memory: self.memory.saturating_sub(running.memory), alone: running.jobs == 0 };
        (!running.by_suspect).then_some(room)
    }

    /// Takes the room of a job that was claimed.
    pub fn admit(self: &Arc<Admission>, lease: &Lease) -> Admitted {
        let mut running = self.running();
        running.jobs += 1;
        running.memory = running.memory.saturating_add(lease.memory);
        running.by_suspect |= lease.suspect;
        Admitted { admission: self.clone(), memory: lease.memory }
    }
}

impl Drop for Admitted {
    fn drop(&mut self) {
        let mut running = self.admission.running();
        running.jobs -= 1;
        running.memory = running.memory.saturating_sub(self.memory);
        // A suspect has nothing beside it.
        running.by_suspect = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::testing::{ALL, fresh};
    use crate::store::{NewJob, Places};

    #[tokio::test]
    async fn jobs_take_room_and_a_suspect_all_of_it() {
        let (_place, store) = fresh().await;
        store.submit(&NewJob::of("match", "1"), Places { queue: 1, of_kind: 1 }).await.unwrap();
        let mut lease = store.claim(&["match"], ALL).await.unwrap().unwrap();
        lease.memory = 60;
        let admission = Arc::new(Admission::new(100));
        assert_eq!(admission.room(), Some(Room { memory: 100, alone: true }));
        let first = admission.admit(&lease);
        assert_eq!(admission.room(), Some(Room { memory: 40, alone: false }));
        let second = admission.admit(&lease);
        assert_eq!(admission.room(), Some(Room { memory: 0, alone: false }));
        drop((first, second));
        lease.suspect = true;
        let suspect = admission.admit(&lease);
        assert_eq!(admission.room(), None);
        drop(suspect);
        assert_eq!(admission.room(), Some(Room { memory: 100, alone: true }));
    }
}
