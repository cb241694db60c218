#include "server/service/catch_as_error.hpp"

#include <exception>
#include <new>

#include "server/core/spectrum/error_spectrum.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/operations/log.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {

namespace {

Error damaged(const std::exception& damage, const std::string& what, const std::string& dataset) {
  log_line(LogLevel::kError, damage.what(), {{"dataset", dataset}});
  return {ErrorCode::kDamagedData, "The dataset's file is damaged in a part that this " + what +
                                       " needs; see the server's log."};
}

}  // namespace

Error error_of_exception(const std::string& what, const std::string& dataset) {
  constexpr double kStoreRetrySeconds = 5;
  try {
    throw;
  } catch (const Cancelled&) {
    return {ErrorCode::kCancelled, "The " + what + " was cancelled."};
  } catch (const std::bad_alloc&) {
    return {ErrorCode::kLimitExceeded, "The server does not have enough memory for this " + what +
                                           "; request a larger error."};
  } catch (const DatasetFileError& damage) {
    return damaged(damage, what, dataset);
  } catch (const DamagedSpectrumError& damage) {
    return damaged(damage, what, dataset);
  } catch (const StoreError& failure) {
    log_line(LogLevel::kError, failure.what(), {{"dataset", dataset}});
    return {.code = ErrorCode::kUnavailable,
            .text = "The store of this dataset does not provide data that this " + what +
                    " needs; see the server's log. Try again.",
            .retry_after = kStoreRetrySeconds};
  } catch (const std::exception& failure) {
    log_line(LogLevel::kError, "creating the " + what + " failed: " + failure.what(),
             {{"dataset", dataset}});
    return {ErrorCode::kInternal, "The server failed to create this " + what + "; see its log."};
  }
}

}  // namespace multitetra
