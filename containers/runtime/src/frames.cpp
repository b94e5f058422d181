// SPDX-License-Identifier: Apache-2.0
#include "frames.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace nacelle::runtime {

class FrameRegistry::Claim final : public FrameClaim {
 public:
  Claim(std::shared_ptr<Claims> claims, ClaimedFrame frame) : claims_(std::move(claims)), child_(frame.child) {
    auto rows = claims_->rows.lock();
    auto& entries = rows->by_child[child_];
    entries.push_back({std::move(frame), &owner_, rows->next_number++});
    elect(entries);
  }
  ~Claim() override { withdraw(); }

  bool is_owner() const override { return owner_.load(std::memory_order_relaxed); }
  std::string owner() const override {
    auto rows = claims_->rows.lock();
    const auto found = rows->by_child.find(child_);
    if (found == rows->by_child.end()) return {};
    for (const auto& entry : found->second) {
      if (entry.owner != &owner_ && entry.owner->load(std::memory_order_relaxed)) return entry.frame.node;
    }
    return {};
  }
  void withdraw() override {
    auto rows = claims_->rows.lock();
    owner_.store(false, std::memory_order_relaxed);
    const auto found = rows->by_child.find(child_);
    if (found == rows->by_child.end()) return;
    std::erase_if(found->second, [&](const Entry& entry) { return entry.owner == &owner_; });
    elect(found->second);
    if (found->second.empty()) rows->by_child.erase(found);
  }

 private:
  const std::shared_ptr<Claims> claims_;
  const std::string child_;
  std::atomic<bool> owner_{false};
};

// Returns the owner among the claims for one child: the first that is not a fallback, else the first fallback.
void FrameRegistry::elect(std::vector<Entry>& entries) {
  const Entry* owner = nullptr;
  for (const auto& entry : entries) {
    if (owner == nullptr ||
        (owner->frame.kind == FrameClaimKind::Fallback && entry.frame.kind != FrameClaimKind::Fallback))
      owner = &entry;
  }
  for (const auto& entry : entries) entry.owner->store(&entry == owner, std::memory_order_relaxed);
}

std::unique_ptr<FrameClaim> FrameRegistry::claim(ClaimedFrame frame) {
  return std::make_unique<Claim>(claims_, std::move(frame));
}

std::vector<ClaimedFrame> FrameRegistry::list() const {
  std::vector<std::pair<std::uint64_t, ClaimedFrame>> numbered;
  {
    auto rows = claims_->rows.lock();
    for (const auto& [child, entries] : rows->by_child) {
      for (const auto& entry : entries) {
        numbered.emplace_back(entry.number, entry.frame);
        numbered.back().second.owns = entry.owner->load(std::memory_order_relaxed);
      }
    }
  }
  std::ranges::sort(numbered, {}, [](const auto& one) { return one.first; });
  std::vector<ClaimedFrame> frames;
  frames.reserve(numbered.size());
  for (auto& [number, frame] : numbered) frames.push_back(std::move(frame));
  return frames;
}

std::vector<std::string> FrameRegistry::claims() const {
  std::vector<std::string> texts;
  for (const auto& frame : list()) texts.push_back("claims the frame " + frame.parent + " -> " + frame.child);
  return texts;
}

void FrameRegistry::withdraw(const std::string& node) {
  auto rows = claims_->rows.lock();
  for (auto row = rows->by_child.begin(); row != rows->by_child.end();) {
    auto& entries = row->second;
    const auto gone = std::erase_if(entries, [&](const Entry& entry) {
      if (entry.frame.node == node) entry.owner->store(false, std::memory_order_relaxed);
      return entry.frame.node == node;
    });
    if (gone != 0) elect(entries);
    row = entries.empty() ? rows->by_child.erase(row) : std::next(row);
  }
}

std::vector<Problem> FrameRegistry::conflicts() const {
  const auto said = [](const ClaimedFrame& frame) {
    return frame.node + (frame.kind == FrameClaimKind::Fixed ? " (fixed to '" : " (from '") + frame.parent + "'" +
           (frame.origin.empty() ? "" : ", " + frame.origin.text()) + ")";
  };
  const auto fit = [](const ClaimedFrame& a, const ClaimedFrame& b) {
    const bool yields = (a.kind == FrameClaimKind::Fallback) != (b.kind == FrameClaimKind::Fallback);
    const bool fixed = a.kind == FrameClaimKind::Fixed || b.kind == FrameClaimKind::Fixed;
    return yields && !fixed && a.parent == b.parent;
  };
  std::vector<Problem> found;
  const std::vector<ClaimedFrame> all = list();
  std::unordered_map<std::string_view, std::vector<std::size_t>> by_child;
  for (std::size_t i = 0; i < all.size(); ++i) by_child[all[i].child].push_back(i);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const std::size_t j : by_child[all[i].child]) {
      const ClaimedFrame& a = all[i];
      const ClaimedFrame& b = all[j];
      if (j <= i || fit(a, b)) continue;
      std::string way_out = "switch one of them off";
      if (!a.origin.empty() && !b.origin.empty())
        way_out = "change " + a.origin.text() + " of " + a.node + ", or " + b.origin.text() + " of " + b.node;
      found.push_back({"frame '" + a.child + "'",
                       (a.parent == b.parent ? "is broadcast twice: by " : "has two parents: it is broadcast by ") +
                           said(a) + " and by " + said(b),
                       std::move(way_out),
                       {},
                       a.child});
    }
  }
  return found;
}

}  // namespace nacelle::runtime
