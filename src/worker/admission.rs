use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::store::{Lease, Room};

/// Which jobs run beside each other on this node: as many as fit its memory together, and a suspect by itself.
pub(super) struct Admission {
    /// Bytes of memory for all jobs together; one that takes more runs alone.
    memory: u64,
    taken: Mutex<Taken>,
}

#[derive(Default)]
struct Taken {
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
        Admission { memory, taken: Mutex::default() }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is free for another job; nothing while a suspect runs.
    pub fn room(&self) -> Option<Room> {
        let taken = self.taken();
        let room = Room { memory: self.memory.saturating_sub(taken.memory), alone: taken.jobs == 0 };
        (!taken.by_suspect).then_some(room)
    }

    /// Takes the room of a job that was claimed.
    pub fn admit(self: &Arc<Admission>, lease: &Lease) -> Admitted {
        let mut taken = self.taken();
        taken.jobs += 1;
        taken.memory = taken.memory.saturating_add(lease.memory);
        taken.by_suspect |= lease.suspect;
        Admitted { admission: self.clone(), memory: lease.memory }
    }
}

impl Drop for Admitted {
    fn drop(&mut self) {
        let mut taken = self.admission.taken();
        taken.jobs -= 1;
        taken.memory = taken.memory.saturating_sub(self.memory);
        // A suspect has nothing beside it.
        taken.by_suspect = false;
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
