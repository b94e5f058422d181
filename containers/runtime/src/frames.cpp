// SPDX-License-Identifier: Apache-2.0
#include "frames.hpp"

#include <algorithm>

namespace nacelle::runtime {

class FrameRegistry::Claim final : public FrameClaim {
 public:
  Claim(std::shared_ptr<Claims> claims, const std::string& node, const std::string& parent, const std::string& child,
        FrameClaimKind kind)
      : claims_(std::move(claims)), child_(child) {
    auto list = claims_->list.lock();
    list->push_back({node, parent, child, kind, &owner_});
    elect(*list, child_);
  }
  ~Claim() override { withdraw(); }

  bool is_owner() const override { return owner_.load(std::memory_order_relaxed); }
  std::string owner() const override {
    auto list = claims_->list.lock();
    for (const auto& entry : *list) {
      if (entry.child == child_ && entry.owner != &owner_ && entry.owner->load(std::memory_order_relaxed))
        return entry.node;
    }
    return {};
  }
  void withdraw() override {
    auto list = claims_->list.lock();
    std::erase_if(*list, [&](const Entry& entry) { return entry.owner == &owner_; });
    owner_.store(false, std::memory_order_relaxed);
    elect(*list, child_);
  }

 private:
  const std::shared_ptr<Claims> claims_;
  const std::string child_;
  std::atomic<bool> owner_{false};
};

// The first primary claim, else the first fallback one.
void FrameRegistry::elect(std::vector<Entry>& entries, const std::string& child) {
  Entry* owner = nullptr;
  for (auto& entry : entries) {
    if (entry.child != child) continue;
    if (owner == nullptr || (owner->kind == FrameClaimKind::Fallback && entry.kind == FrameClaimKind::Primary))
      owner = &entry;
  }
  for (auto& entry : entries) {
    if (entry.child == child) entry.owner->store(&entry == owner, std::memory_order_relaxed);
  }
}

std::unique_ptr<FrameClaim> FrameRegistry::claim(const std::string& node, const std::string& parent,
                                                 const std::string& child, FrameClaimKind kind) {
  return std::make_unique<Claim>(claims_, node, parent, child, kind);
}

std::vector<std::string> FrameRegistry::claims() const {
  std::vector<std::string> texts;
  auto list = claims_->list.lock();
  for (const auto& entry : *list) texts.push_back("claims the frame " + entry.parent + " -> " + entry.child);
  return texts;
}

void FrameRegistry::withdraw(const std::string& node) {
  auto list = claims_->list.lock();
  std::vector<std::string> children;
  std::erase_if(*list, [&](const Entry& entry) {
    if (entry.node != node) return false;
    entry.owner->store(false, std::memory_order_relaxed);
    children.push_back(entry.child);
    return true;
  });
  for (const auto& child : children) elect(*list, child);
}

std::vector<Problem> FrameRegistry::conflicts() const {
  std::vector<Problem> found;
  auto list = claims_->list.lock();
  for (std::size_t i = 0; i < list->size(); ++i) {
    for (std::size_t j = i + 1; j < list->size(); ++j) {
      const Entry& a = (*list)[i];
      const Entry& b = (*list)[j];
      if (a.child != b.child || a.kind != FrameClaimKind::Primary || b.kind != FrameClaimKind::Primary) continue;
      found.push_back(
          {"frame " + a.child,
           "broadcast by two nodes: " + a.node + " (from " + a.parent + ") and " + b.node + " (from " + b.parent + ")",
           "switch one off, e.g. publish_tf or enable_odom_tf"});
    }
  }
  return found;
}

}  // namespace nacelle::runtime
