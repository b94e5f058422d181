// SPDX-License-Identifier: Apache-2.0
#include "frames.hpp"

#include <algorithm>

namespace nacelle::runtime {

class FrameRegistry::Claim final : public FrameClaim {
 public:
  Claim(std::shared_ptr<Claims> claims, ClaimedFrame frame) : claims_(std::move(claims)), child_(frame.child) {
    auto list = claims_->list.lock();
    list->push_back({std::move(frame), &owner_});
    elect(*list, child_);
  }
  ~Claim() override { withdraw(); }

  bool is_owner() const override { return owner_.load(std::memory_order_relaxed); }
  std::string owner() const override {
    auto list = claims_->list.lock();
    for (const auto& entry : *list) {
      if (entry.frame.child == child_ && entry.owner != &owner_ && entry.owner->load(std::memory_order_relaxed))
        return entry.frame.node;
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

// The first claim that is no fallback, else the first fallback.
void FrameRegistry::elect(std::vector<Entry>& entries, const std::string& child) {
  Entry* owner = nullptr;
  for (auto& entry : entries) {
    if (entry.frame.child != child) continue;
    if (owner == nullptr ||
        (owner->frame.kind == FrameClaimKind::Fallback && entry.frame.kind != FrameClaimKind::Fallback))
      owner = &entry;
  }
  for (auto& entry : entries) {
    if (entry.frame.child == child) entry.owner->store(&entry == owner, std::memory_order_relaxed);
  }
}

std::unique_ptr<FrameClaim> FrameRegistry::claim(ClaimedFrame frame) {
  return std::make_unique<Claim>(claims_, std::move(frame));
}

std::vector<ClaimedFrame> FrameRegistry::list() const {
  std::vector<ClaimedFrame> frames;
  auto list = claims_->list.lock();
  for (const auto& entry : *list) {
    frames.push_back(entry.frame);
    frames.back().owns = entry.owner->load(std::memory_order_relaxed);
  }
  return frames;
}

std::vector<std::string> FrameRegistry::claims() const {
  std::vector<std::string> texts;
  auto list = claims_->list.lock();
  for (const auto& entry : *list)
    texts.push_back("claims the frame " + entry.frame.parent + " -> " + entry.frame.child);
  return texts;
}

void FrameRegistry::withdraw(const std::string& node) {
  auto list = claims_->list.lock();
  std::vector<std::string> children;
  std::erase_if(*list, [&](const Entry& entry) {
    if (entry.frame.node != node) return false;
    entry.owner->store(false, std::memory_order_relaxed);
    children.push_back(entry.frame.child);
    return true;
  });
  for (const auto& child : children) elect(*list, child);
}

std::vector<Problem> FrameRegistry::conflicts() const {
  const auto said = [](const ClaimedFrame& frame) {
    return frame.node + (frame.kind == FrameClaimKind::Fixed ? " (fixed to '" : " (from '") + frame.parent + "'" +
           (frame.origin.empty() ? "" : ", " + frame.origin) + ")";
  };
  const auto fit = [](const ClaimedFrame& a, const ClaimedFrame& b) {
    const bool yields = (a.kind == FrameClaimKind::Fallback) != (b.kind == FrameClaimKind::Fallback);
    const bool fixed = a.kind == FrameClaimKind::Fixed || b.kind == FrameClaimKind::Fixed;
    return yields && !fixed && a.parent == b.parent;
  };
  std::vector<Problem> found;
  const std::vector<ClaimedFrame> all = list();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const ClaimedFrame& a = all[i];
      const ClaimedFrame& b = all[j];
      if (a.child != b.child || fit(a, b)) continue;
      std::string way_out = "switch one of them off";
      if (!a.origin.empty() && !b.origin.empty())
        way_out = "change " + a.origin + " of " + a.node + ", or " + b.origin + " of " + b.node;
      found.push_back({"frame '" + a.child + "'",
                       (a.parent == b.parent ? "is broadcast twice: by " : "has two parents: it is broadcast by ") +
                           said(a) + " and by " + said(b),
                       std::move(way_out)});
    }
  }
  return found;
}

}  // namespace nacelle::runtime
