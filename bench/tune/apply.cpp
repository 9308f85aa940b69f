#include "tune/apply.h"

#include "base/stopwatch.h"
#include "plait/extend/copy_levels.h"
#include "store/partial_store.h"

namespace plait::tune {

Applied apply(Store& source, const Choice& choice, const std::filesystem::path& out, bool force,
              const BackendRegistry& backends, const ProgressCallback& progress) {
  Applied applied;
  PartialStore output(out, force ? Existing::kReplace : Existing::kRefuse);
  const Stopwatch clock;
  build_output(output, [&] {
    Store copy = Store::create(output.make(), source.base(), options_of_copy(source, choice),
                               backends, source.provenance());
    copy_levels(source, copy, progress);
    copy.commit();
    applied.stored_bytes = static_cast<double>(copy.stored_bytes());
    copy.close();
  });
  output.publish(true);
  applied.store = output.final_path();
  applied.seconds = clock.seconds();
  return applied;
}

}  // namespace plait::tune
