#include "server/programs/local_surface.hpp"

#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/net/net.hpp"
#include "server/operations/log.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/service/local_service.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kNoLimit = std::size_t{1} << 60;

// Keeps the exception of which the service tells its clients only the kind.
class LocalProvider : public CachingSurfaceProvider {
 public:
  using CachingSurfaceProvider::CachingSurfaceProvider;

  EncodedStep make_meshes(const StepRequest& step, std::stop_token stop) const override {
    try {
      return CachingSurfaceProvider::make_meshes(step, std::move(stop));
    } catch (...) {
      failure_ = std::current_exception();
      throw;
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  mutable std::exception_ptr failure_;
};

asio::awaitable<Result<Surface>> requested(ServiceClientPtr client, SurfacesRequest wanted) {
  if (const auto known = co_await client->log_in(""); !known) {
    co_return tl::unexpected(known.error());
  }
  std::function<Result<Surface>(std::vector<Surface>, const std::stop_token&)> first =
      [](std::vector<Surface> made, const std::stop_token&) -> Result<Surface> {
    return std::move(made.front());
  };
  co_return co_await client->made_from_surfaces<Surface>(std::move(wanted), "mesh file",
                                                         std::move(first));
}

}  // namespace

Surface local_surface(const std::shared_ptr<const SurfaceExtractor>& extractor,
                      const IsosurfaceRequest& request) {
  set_log_level(LogLevel::kOff);
  const auto provider = std::make_shared<const LocalProvider>(extractor);
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(provider);
  asio::io_context context(1);
  AdmissionControl admission({.queue_bytes = kNoLimit});
  LocalService service(context.get_executor(), catalogue, {.workers = 1});
  std::optional<Result<Surface>> made;
  asio::co_spawn(context,
                 requested(service.open(admission.admit("local", "", "").client),
                           {.dataset = provider->info().name, .requests = {request}}),
                 [&](const std::exception_ptr& failure, Result<Surface> surface) {
                   if (failure) std::rethrow_exception(failure);
                   made = std::move(surface);
                 });
  context.run();
  service.join();
  if (*made) return **std::move(made);
  provider->rethrow();
  throw std::runtime_error(made->error().text);
}

}  // namespace multitetra
