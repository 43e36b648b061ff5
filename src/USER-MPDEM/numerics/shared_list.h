// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A list that is stored once for all owners of an equal one. Bonds of one shape are equal in all but their state:
// positions of points and links, constraints of nodes, masses. An owner that changes its list gets its own copy first.
// So sharing affects only memory.
#ifndef MPDEM_NUMERICS_SHARED_LIST_H
#define MPDEM_NUMERICS_SHARED_LIST_H

#include <cstring>
#include <map>
#include <memory>
#include <string_view>
#include <type_traits>
#include <typeindex>
#include <utility>
#include <vector>

namespace mpdem {

template <class T>
class SharedList {
  static_assert(std::is_trivially_copyable_v<T>, "lists are compared by their bytes");

 public:
  SharedList() = default;
  SharedList(std::vector<T> list) : list_(std::make_shared<std::vector<T>>(std::move(list))) {}

  std::size_t size() const { return list_ ? list_->size() : 0; }
  bool empty() const { return size() == 0; }
  const T* data() const { return list_ ? list_->data() : nullptr; }
  const T& operator[](std::size_t i) const { return (*list_)[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }

  // Gives access to change the list. Copies it first if it is shared.
  std::vector<T>& own() {
    if (!list_) list_ = std::make_shared<std::vector<T>>();
    else if (list_.use_count() > 1) list_ = std::make_shared<std::vector<T>>(*list_);
    return *list_;
  }

  // Memory of the list in bytes, divided by the number of its owners.
  std::size_t memory_usage() const { return list_ ? list_->capacity() * sizeof(T) / static_cast<std::size_t>(list_.use_count()) : 0; }

 private:
  friend class AlikeLists;
  std::shared_ptr<std::vector<T>> list_;
};

// The lists in use, found by a hash of their bytes.
class AlikeLists {
 public:
  // Makes `list` share the memory of an equal known list. If there is none, `list` becomes known, unless another list has its hash.
  template <class T>
  void share(SharedList<T>& list) {
    if (list.empty()) return;
    const std::string_view bytes(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T));
    std::weak_ptr<void>& at = known_[{std::type_index(typeid(T)), std::hash<std::string_view>()(bytes)}];
    const auto other = std::static_pointer_cast<std::vector<T>>(at.lock());
    if (!other) {
      list.list_->shrink_to_fit();
      at = list.list_;
    } else if (other->size() == list.size() && std::memcmp(other->data(), list.data(), bytes.size()) == 0) {
      list.list_ = other;
    }
    forget_unused();
  }
  // Number of known lists, including some that are freed already.
  std::size_t size() const { return known_.size(); }

 private:
  void forget_unused() {
    if (known_.size() < next_cleanup_size_) return;
    for (auto k = known_.begin(); k != known_.end();) k = k->second.expired() ? known_.erase(k) : std::next(k);
    next_cleanup_size_ = 2 * known_.size() + kFewest;
  }
  static constexpr std::size_t kFewest = 1000;
  std::size_t next_cleanup_size_ = kFewest;  // number of lists at which the next search for unused ones is due
  std::map<std::pair<std::type_index, std::size_t>, std::weak_ptr<void>> known_;
};

}  // namespace mpdem

#endif
