#include "common/messages.hpp"
