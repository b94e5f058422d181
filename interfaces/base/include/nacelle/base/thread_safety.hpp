// SPDX-License-Identifier: Apache-2.0
/// Words that say which lock guards what. clang checks them in each build (-Wthread-safety); for g++ they are empty.
/// NACELLE_LIFETIME_BOUND, of a member function: what it returns refers to the object, so it must not outlive it (-Wdangling).
/// Source: https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
#pragma once

#if defined(__clang__)
#define NACELLE_THREAD_SAFETY(words) __attribute__((words))
#define NACELLE_LIFETIME_BOUND [[clang::lifetimebound]]
#else
#define NACELLE_THREAD_SAFETY(words)
#define NACELLE_LIFETIME_BOUND
#endif

/// Of a class: a lock.
#define NACELLE_CAPABILITY(name) NACELLE_THREAD_SAFETY(capability(name))
/// Of a class: takes a lock in its constructor and releases it in its destructor.
#define NACELLE_SCOPED_CAPABILITY NACELLE_THREAD_SAFETY(scoped_lockable)
/// Of a variable: read and written only while the lock is held.
#define NACELLE_GUARDED_BY(lock) NACELLE_THREAD_SAFETY(guarded_by(lock))
/// Of a function: the caller holds the locks.
#define NACELLE_REQUIRES(...) NACELLE_THREAD_SAFETY(requires_capability(__VA_ARGS__))
/// Of a function: it takes the locks itself, so the caller must not hold them.
#define NACELLE_EXCLUDES(...) NACELLE_THREAD_SAFETY(locks_excluded(__VA_ARGS__))
/// Of a function: it returns with the locks held.
#define NACELLE_ACQUIRE(...) NACELLE_THREAD_SAFETY(acquire_capability(__VA_ARGS__))
/// Of a function: it returns with the locks released.
#define NACELLE_RELEASE(...) NACELLE_THREAD_SAFETY(release_capability(__VA_ARGS__))
/// Of a function: if it returns the given value, the lock is held.
#define NACELLE_TRY_ACQUIRE(...) NACELLE_THREAD_SAFETY(try_acquire_capability(__VA_ARGS__))
/// Of a function: it is another name of the lock.
#define NACELLE_RETURNS_LOCK(lock) NACELLE_THREAD_SAFETY(lock_returned(lock))
/// Of a function: from its call on, the compiler takes the lock as held. For a lock that has two names.
#define NACELLE_ASSERTS_HELD(...) NACELLE_THREAD_SAFETY(assert_capability(__VA_ARGS__))
/// Of a function: its body is not checked. A comment beside it says why.
#define NACELLE_NOT_CHECKED NACELLE_THREAD_SAFETY(no_thread_safety_analysis)
