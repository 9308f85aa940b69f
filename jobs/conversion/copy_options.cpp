#include "conversion/copy_options.h"

#include <fmt/format.h>

#include <system_error>

#include "job_rules.h"
#include "plait/error.h"
#include "store/attribute_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

BackendChoice choose_backend_of_copy(const CopyChoices& choices, const Store& source,
                                     const BackendRegistry& backends) {
  if (choices.backend == kAutomaticBackend) {
    std::uint64_t raw_bytes = 0;
    for (AttributeId id = 0; id < source.attributes().size(); ++id)
      raw_bytes += bytes_of_levels(source, id);
    return backends.choose({choices.to, raw_bytes, choices.compresses, {}});
  }
  if (!choices.backend.empty()) return {choices.backend, "given by the user"};
  if (choices.compresses) return {"compressed", "because of the compression"};
  return {source.options().backend, "the same as the source"};
}

const RegisteredBackend& find_backend_of_copy(const CopyChoices& choices,
                                              const std::string& backend, const char* verb,
                                              const BackendRegistry& backends) {
  const RegisteredBackend& found = backends.find(backend);
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kInvalidArgument, fmt::format("{}{}", verb, reason));
  };
  if (!found.traits.durable) throw refuse(fmt::format(": backend {} writes no files", found.name));
  if (!found.traits.compressed && choices.compresses) throw needs_compression(verb, found);
  found.check_machine();
  std::error_code ignored;
  if (std::filesystem::equivalent(choices.from, choices.to, ignored))
    throw refuse(fmt::format(" {}: source and copy are the same", choices.from.native()));
  return found;
}

void set_common_options(const CopyChoices& choices, const Store& source,
                        const BackendTraits& traits, StoreOptions& options) {
  options.block_bytes =
      choices.block_bytes != 0
          ? choices.block_bytes
          : block_bytes_of_copy(source.info().backend, source.options().block_bytes, traits);
  options.budget_bytes = choices.budget_bytes / 2;
  options.durability = Durability::kCommit;
}

PLAIT_END_NAMESPACE
