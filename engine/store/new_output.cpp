#include "store/new_output.h"

#include <fmt/format.h>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Error directory_name_taken(const std::filesystem::path& path) {
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("create {}: it exists already", path.native()))
      .about(path);
}

}  // namespace

std::filesystem::path make_new_store(
    const std::filesystem::path& path, Existing existing, Durability durability, const Warn& warn,
    const std::function<void(const std::filesystem::path&)>& make) {
  UnpublishedStore output(path, existing, warn);
  build_output(output, [&] { make(output.make()); });
  output.publish(durability == Durability::kCommit);
  return output.final_path();
}

std::filesystem::path make_new_file(const std::filesystem::path& path, Existing existing,
                                    const Warn& warn,
                                    const std::function<void(UnpublishedFile&)>& make) {
  UnpublishedFile output(path, existing);
  remove_left_overs_of(path, warn);
  build_output(output, [&] { make(output); });
  output.publish();
  return output.final_path();
}

void check_new_directory(const std::filesystem::path& path) {
  if (const OutputName output(path); output.directory.contains(output.name))
    throw directory_name_taken(output.path);
}

std::filesystem::path make_new_directory(const std::filesystem::path& path, const Warn& warn,
                                         UnpublishedDirectory::RemoveContent remove_content,
                                         const std::function<void(const Directory&)>& make) {
  check_new_directory(path);
  UnpublishedDirectory output(OutputName(path).path, "partial", MadeProof::kMark, remove_content);
  remove_left_overs_of(path, warn);
  make(output.directory());
  try {
    if (!output.publish(true)) throw directory_name_taken(output.final_path());
  } catch (const Error& error) {
    // kBadState: another process has taken the directory away.
    if (output.has_final_name() || error.code() == ErrorCode::kBadState) throw;
    throw Error(error.code(), fmt::format("{}; the new directory is complete and stays at {}",
                                          error.what(), output.keep().native()))
        .about(output.final_path());
  }
  return output.final_path();
}

PLAIT_END_NAMESPACE
