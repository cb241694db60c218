#include "common/frame.hpp"
