#include "common/tile.hpp"
