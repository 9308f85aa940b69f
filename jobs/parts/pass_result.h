// The attribute that a pass makes, and the version of a store that then has it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "format/version_description.h"
#include "plait/extend/pass.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Errors: kInvalidArgument for a pass that no store can have: an unknown name without a kernel, an
/// option out of range.
void check_pass(const Pass& pass);

/// The attribute that a pass makes of a store with these attributes.
struct PassResult {
  AttributeSchema schema;
  /// The attribute whose levels it has: "position"; of an own pass, the one that it replaces, else
  /// the one with most levels.
  std::size_t like = 0;
  std::size_t encoded_like = 0;  ///< whose pipelines it has: the one that it replaces, else `like`
  bool replaces = false;
};

/// `finest` are the levels of the attributes. Errors: kInvalidArgument for a pass that does not
/// fit; kNotFound without "position".
PassResult result_of(const Pass& pass, const std::vector<AttributeSchema>& schemas,
                     const std::vector<int>& finest);

/// The description of the version after `at` with the result of the pass, without shards and
/// without the checksum of the result's base records. `version` is its number, `program` the
/// version of plait that makes it. Errors: as result_of().
VersionDescription version_after(const VersionDescription& at, const Pass& pass,
                                 std::uint64_t version, const std::string& program);

/// Makes the pass. Returns the result's id. Errors: those of run_pass().
AttributeId make_result(Store& store, const Pass& pass, const VisitOptions& options,
                        PassFigures& figures);

PLAIT_END_NAMESPACE
