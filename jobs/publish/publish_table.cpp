// The job "publish".
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "conversion/conversion_job.h"
#include "conversion/read_back.h"
#include "format/file_names.h"
#include "job.h"
#include "plait/bounds.h"
#include "plait/error.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "publish/make_view.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct PublishArguments : ConversionRequest {
  bool page = false;
};

/// Writes a new file of a directory.
void write_file(const Directory& directory, const char* name, std::span<const std::byte> bytes) {
  File file(directory, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

JobReport run_publish(PublishArguments& arguments, const JobCall& call) {
  // Browsers read records by their places in the files, so the copy has them raw, in whole files.
  arguments.backend = "pread";
  arguments.verb = "publish";
  arguments.parallel_for = call.parallel_for;
  std::vector<std::byte> view;
  std::uint64_t faces = 0;
  arguments.finish = [&](const std::filesystem::path& path) {
    OpenOptions open;
    open.budget_bytes = arguments.budget_bytes;
    Store copy = Store::open(path, open, call.backends);
    faces = copy.base().face_count();
    view = make_view(copy, begin_step(call.watch, "view"));
    write_bounds(copy, "position", begin_step(call.watch, "bounds"));
    const Directory directory(path);
    write_file(directory, kViewName, view);
    if (arguments.page) write_file(directory, kPageName, std::as_bytes(std::span(viewer_page())));
    directory.sync();
  };
  const ConversionResult done = convert(arguments, call.open_backends, call.backends, call.watch);
  const std::uint64_t page_bytes = viewer_page().size();
  return {{"from", arguments.from.string()},
          {"store", done.store.string()},
          {"faces", faces},
          {"stored_bytes", done.stored_bytes},
          {"view_bytes", view.size()},
          {"page_bytes", arguments.page ? page_bytes : 0},
          {"first_view",
           {{"requests", arguments.page ? 2 : 1},
            {"bytes", view.size() + (arguments.page ? page_bytes : 0)}}}};
}

}  // namespace

Job publish_job() {
  JobTable<PublishArguments> table("publish",
                                   "Copy a store so that browsers can show it from any web server");
  table.path("input", &PublishArguments::from, "The store").at(0).required();
  table.output("output", &PublishArguments::to, "The directory to make: a store as well")
      .at(1)
      .required();
  table.flag("page", &PublishArguments::page, "Put the page that shows the store into it");
  table.bytes(
      "memory", &PublishArguments::budget_bytes,
      "Budget for blocks in memory; half of it for the source, or less where it needs less");
  table.force(&PublishArguments::existing);
  return table.run(run_publish);
}

PLAIT_END_NAMESPACE
