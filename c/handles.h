// handles.h: what the opaque types of plait.h are.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plait.h"
#include "plait/reader.h"
#include "plait/store.h"

namespace plait::c {

/// Handles of readers and views that use one store. It outlives the handle of the store.
struct Users {
  std::atomic<std::uint64_t> readers = 0, views = 0;
};

/// Counts one reader or one view while it lives.
class Counted {
 public:
  Counted(std::shared_ptr<Users> users, std::atomic<std::uint64_t> Users::*kind)
      : users_(std::move(users)), kind_(kind) {
    ++((*users_).*kind_);
  }
  ~Counted() { --((*users_).*kind_); }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  const std::shared_ptr<Users>& users() const { return users_; }

 private:
  std::shared_ptr<Users> users_;
  std::atomic<std::uint64_t> Users::*kind_;
};

}  // namespace plait::c

struct plait_store {
  plait_store(plait::Store opened, bool for_writing)
      : store(std::move(opened)), writable(for_writing) {}

  plait::Store store;
  bool writable;
  std::shared_ptr<plait::c::Users> users = std::make_shared<plait::c::Users>();
};

struct plait_reader {
  plait_reader(const plait_store& of, const plait::ReaderOptions& options)
      : reader(of.store, options), counted(of.users, &plait::c::Users::readers) {
    for (const plait::AttributeInfo& info : of.store.attributes()) schemas.push_back(info.schema);
  }

  plait::Reader reader;
  plait::c::Counted counted;
  std::vector<plait::AttributeSchema> schemas;
};

/// A view of its own, or one that a visit of patches lends to its callback.
struct plait_view {
  explicit plait_view(const plait::PatchView& lent) : patch(&lent) {}
  plait_view(plait::PatchView view, const plait_reader& reader)
      : own(std::move(view)), patch(&own) {
    counted.emplace(reader.counted.users(), &plait::c::Users::views);
  }
  plait_view(const plait_view&) = delete;
  plait_view& operator=(const plait_view&) = delete;

  plait::PatchView own;
  const plait::PatchView* patch;
  std::optional<plait::c::Counted> counted;
};

namespace plait::c {

/// The store of a handle that a call changes. Errors: kInvalidArgument for NULL; kBusy while the
/// store has readers or views.
Store& changed_store(plait_store* handle);
/// The store of a handle that a call only reads. Errors: kInvalidArgument for NULL.
const Store& read_store(const plait_store* handle);
/// Errors: kNotFound; kInvalidArgument for NULL.
AttributeId attribute_named(const Store& store, const char* name);
/// Errors: kInvalidArgument unless the attribute has this level.
void check_level(const Store& store, AttributeId attribute, std::int32_t level);

}  // namespace plait::c
