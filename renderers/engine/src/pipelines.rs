//! Shaders and pipelines of a device, kept for equal requests: another view, another frame, another scene.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cvr_core::shader::{Binding, Draft, GeneratedShader};

/// Largest number of shaders, and of pipelines, that a device keeps. The least recently used ones are dropped.
const MOST_KEPT: usize = 64;

/// Shaders and pipelines that a device keeps.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    shaders: Mutex<Recent<Draft, Arc<GeneratedShader>>>,
    compiled: Mutex<Recent<Key, Arc<Compiled>>>,
    made: AtomicU64,
}

/// The parts that determine a pipeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    pub(crate) wgsl: String,
    pub(crate) entry: String,
    pub(crate) bindings: Vec<Binding>,
    pub(crate) target: Target,
}

/// What runs a shader.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    /// Dispatches.
    Compute,
    /// Triangles, blended into a picture of this format.
    Blend { vertex: &'static str, format: wgpu::TextureFormat },
}

/// A compiled shader.
#[derive(Debug)]
pub(crate) struct Compiled {
    pub(crate) bindings: Vec<Binding>,
    /// One for each group of bindings.
    pub(crate) layouts: Vec<wgpu::BindGroupLayout>,
    pub(crate) pipeline: Executable,
}

#[derive(Debug)]
pub(crate) enum Executable {
    Compute(wgpu::ComputePipeline),
    Blend(wgpu::RenderPipeline),
}

impl Pipelines {
    /// The shader of a draft: one that was made before, if there is one.
    pub(crate) fn shader<E>(
        &self,
        draft: Draft,
        make: impl FnOnce() -> Result<GeneratedShader, E>,
    ) -> Result<Arc<GeneratedShader>, E> {
        kept(&self.shaders, draft, make)
    }

    /// The pipeline of a key: one that was made before, if there is one.
    pub(crate) fn compiled<E>(
        &self,
        key: Key,
        make: impl FnOnce() -> Result<Compiled, E>,
    ) -> Result<Arc<Compiled>, E> {
        kept(&self.compiled, key, || {
            let compiled = make()?;
            self.made.fetch_add(1, Ordering::Relaxed);
            Ok(compiled)
        })
    }

    /// Pipelines that were made so far.
    pub(crate) fn made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    /// Forgets shaders and pipelines.
    pub(crate) fn forget(&self) {
        *lock(&self.shaders) = Recent::default();
        *lock(&self.compiled) = Recent::default();
    }
}

/// The value of a key, which is made unless it is there. Nothing waits for another's making.
fn kept<K: Hash + Eq + Clone, V, E>(
    all: &Mutex<Recent<K, Arc<V>>>,
    key: K,
    make: impl FnOnce() -> Result<V, E>,
) -> Result<Arc<V>, E> {
    if let Some(value) = lock(all).get(&key) {
        return Ok(value);
    }
    let value = Arc::new(make()?);
    lock(all).insert(key, Arc::clone(&value));
    Ok(value)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Values by their keys, at most [`MOST_KEPT`].
#[derive(Debug)]
struct Recent<K, V> {
    kept: HashMap<K, (V, u64)>,
    asked: u64,
}

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self { kept: HashMap::new(), asked: 0 }
    }
}

impl<K: Hash + Eq + Clone, V: Clone> Recent<K, V> {
    fn get(&mut self, key: &K) -> Option<V> {
        self.asked += 1;
        let (value, asked) = self.kept.get_mut(key)?;
        *asked = self.asked;
        Some(value.clone())
    }

    fn insert(&mut self, key: K, value: V) {
        let longest = || self.kept.iter().min_by_key(|(_, (_, asked))| *asked).map(|(key, _)| key.clone());
        if self.kept.len() >= MOST_KEPT
            && !self.kept.contains_key(&key)
            && let Some(longest) = longest()
        {
            self.kept.remove(&longest);
        }
        self.asked += 1;
        self.kept.insert(key, (value, self.asked));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_not_been_asked_for_longest_goes() {
        let mut recent = Recent::default();
        (0..MOST_KEPT).for_each(|i| recent.insert(i, 2 * i));
        assert_eq!(recent.get(&0), Some(0));
        recent.insert(MOST_KEPT, 7);
        recent.insert(MOST_KEPT, 8);
        assert_eq!(recent.kept.len(), MOST_KEPT);
        assert_eq!([0, 1, 2, MOST_KEPT].map(|key| recent.get(&key)), [Some(0), None, Some(4), Some(8)]);
    }
}
