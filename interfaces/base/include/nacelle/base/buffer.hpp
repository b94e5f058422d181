// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <new>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

namespace nacelle {

/// Gives foreign memory back to its owner. Called once, from whichever thread drops the last use; must not throw.
struct ReleaseHook {
  void (*release)(void* context) noexcept = nullptr;
  void* context = nullptr;
};

/// While it lives, copies of Buffers of at least kBytes that this thread makes have memory and size of the original, and not
/// its elements: a pool reserves messages like another one, and the kernel gives their pages when they are first written.
class ReservingCopies {
 public:
  static constexpr std::size_t kBytes = std::size_t{64} * 1024;
  ReservingCopies();
  ~ReservingCopies();
  ReservingCopies(const ReservingCopies&) = delete;
  ReservingCopies& operator=(const ReservingCopies&) = delete;
  [[nodiscard]] static bool are_on();
};

/// A sequence of numbers with std::vector's surface that can also hold memory it does not own.
///
/// An Image's `data` is one of these: it may be a mapped capture buffer of the kernel, a block of a pool or plain heap,
/// and a reader cannot tell. Reading never copies. resize() within the capacity stays in place; growth, and a copy of the
/// Buffer, allocate memory of its own and leave the foreign memory.
///
/// Ownership: adopt() lends memory until the Buffer is destroyed, grows, is reassigned or give_back() is called; the hook
///            then runs exactly once.
/// Threads:   as std::vector. Errors: at() throws std::out_of_range, growth std::bad_alloc.
/// Allocates: only in growth and copies. New elements of a resize() are zero, as in std::vector.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>, "a Buffer holds plain numbers");

 public:
  using value_type = T;
  using size_type = std::size_t;
  using difference_type = std::ptrdiff_t;
  using reference = T&;
  using const_reference = const T&;
  using iterator = T*;
  using const_iterator = const T*;

  Buffer() = default;
  explicit Buffer(size_type n, T value = T{}) { assign(n, value); }
  Buffer(std::initializer_list<T> values) { assign(values.begin(), values.end()); }
  Buffer(const std::vector<T>& values) { assign(values.begin(), values.end()); }  // NOLINT(google-explicit-constructor)
  template <std::input_iterator It>
  Buffer(It first, It last) {
    assign(first, last);
  }
  Buffer(const Buffer& other) { copy_from(other.data_, other.size_); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(const Buffer& other) {
    if (this != &other) copy_from(other.data_, other.size_);
    return *this;
  }
  Buffer& operator=(Buffer&& other) noexcept {
    if (this != &other) {
      drop();
      swap(other);
    }
    return *this;
  }
  Buffer& operator=(std::initializer_list<T> values) {
    assign(values.begin(), values.end());
    return *this;
  }
  Buffer& operator=(const std::vector<T>& values) {
    copy_from(values.data(), values.size());
    return *this;
  }
  ~Buffer() { drop(); }

  /// Holds foreign memory from now on: `size` elements of `capacity` that fit. The hook runs when it is no longer used.
  void adopt(T* memory, size_type size, size_type capacity, ReleaseHook hook) {
    drop();
    data_ = memory;
    size_ = size;
    capacity_ = capacity;
    hook_ = hook;
    foreign_ = true;
  }
  /// True while the elements live in adopted memory.
  [[nodiscard]] bool is_foreign() const { return foreign_; }
  /// Returns adopted memory to its owner and is empty then; own memory is kept for reuse.
  void give_back() {
    if (foreign_) drop();
  }

  [[nodiscard]] size_type size() const { return size_; }
  [[nodiscard]] size_type capacity() const { return capacity_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] iterator begin() { return data_; }
  [[nodiscard]] iterator end() { return data_ + size_; }
  [[nodiscard]] const_iterator begin() const { return data_; }
  [[nodiscard]] const_iterator end() const { return data_ + size_; }
  [[nodiscard]] const_iterator cbegin() const { return data_; }
  [[nodiscard]] const_iterator cend() const { return data_ + size_; }
  [[nodiscard]] T& operator[](size_type i) { return data_[i]; }
  [[nodiscard]] const T& operator[](size_type i) const { return data_[i]; }
  [[nodiscard]] T& at(size_type i) { return i < size_ ? data_[i] : out_of_range(); }
  [[nodiscard]] const T& at(size_type i) const { return i < size_ ? data_[i] : out_of_range(); }
  [[nodiscard]] T& front() { return data_[0]; }
  [[nodiscard]] const T& front() const { return data_[0]; }
  [[nodiscard]] T& back() { return data_[size_ - 1]; }
  [[nodiscard]] const T& back() const { return data_[size_ - 1]; }

  void clear() { size_ = 0; }
  void reserve(size_type n) {
    if (n > capacity_) grow_to(n);
  }
  void resize(size_type n, T value = T{}) {
    const size_type before = size_;
    resize_uninitialized(n);
    if (n > before) std::fill(data_ + before, data_ + n, value);
  }
  /// As resize(), but new elements hold whatever the memory held: for a writer that fills them all.
  void resize_uninitialized(size_type n) {
    if (n > capacity_) grow_to(n);
    size_ = n;
  }
  void push_back(T value) {
    if (size_ == capacity_) grow_to(std::max<size_type>(8, capacity_ * 2));
    data_[size_++] = value;
  }
  void pop_back() { --size_; }
  void assign(size_type n, T value) {
    resize_uninitialized(n);
    std::fill(begin(), end(), value);
  }
  template <std::input_iterator It>
  void assign(It first, It last) {
    if constexpr (std::random_access_iterator<It>) {
      resize_uninitialized(static_cast<size_type>(last - first));
      std::copy(first, last, data_);
    } else {
      clear();
      for (; first != last; ++first) push_back(*first);
    }
  }
  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    std::swap(hook_, other.hook_);
    std::swap(foreign_, other.foreign_);
  }

  operator std::span<const T>() const { return {data_, size_}; }  // NOLINT(google-explicit-constructor)
  friend bool operator==(const Buffer& a, const Buffer& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  [[noreturn]] static T& out_of_range() { throw std::out_of_range("Buffer::at: index beyond size"); }

  void copy_from(const T* from, size_type n) {
    // A copy is a message of its own: it never shares foreign memory with the original.
    if (foreign_) drop();
    resize_uninitialized(n);
    if (n >= ReservingCopies::kBytes / sizeof(T) && ReservingCopies::are_on()) return;
    if (n != 0) std::memcpy(static_cast<void*>(data_), from, n * sizeof(T));
  }
  void grow_to(size_type n) {
    if (n > static_cast<size_type>(-1) / sizeof(T)) throw std::bad_alloc{};
    T* const bigger = static_cast<T*>(::operator new(n * sizeof(T)));
    const size_type kept = std::min(size_, n);  // never more than n: said so that the compiler can see it
    if (kept != 0) std::memcpy(static_cast<void*>(bigger), data_, kept * sizeof(T));
    drop();
    data_ = bigger;
    size_ = kept;
    capacity_ = n;
  }
  void drop() noexcept {
    if (foreign_) {
      if (hook_.release != nullptr) hook_.release(hook_.context);
    } else {
      ::operator delete(data_);
    }
    data_ = nullptr;
    size_ = capacity_ = 0;
    hook_ = {};
    foreign_ = false;
  }

  T* data_ = nullptr;
  size_type size_ = 0;
  size_type capacity_ = 0;
  ReleaseHook hook_;
  bool foreign_ = false;
};

}  // namespace nacelle
