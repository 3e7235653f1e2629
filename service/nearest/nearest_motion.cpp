#include "nearest/nearest_motion.h"
