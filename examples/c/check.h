/* For the examples: a call that fails says why, and ends the program. */

#ifndef CHECK_H
#define CHECK_H

#include <lostmotion.h>
#include <stdio.h>
#include <stdlib.h>

#define CHECK(call)                                                                                \
    do {                                                                                           \
        if ((call) != LM_STATUS_OK) {                                                              \
            LmError why_;                                                                          \
            (void)lm_error(&why_);                                                                \
            fprintf(stderr, "%s:%d: %s [%s]\n%s\n", __FILE__, __LINE__, why_.message, why_.code,   \
                    why_.hint);                                                                    \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

#endif
