; Moves the X axis of an IF1 from the first serial port of a PC, and prints the position.
;
;   a program for DOS          nasm feed.asm -o FEED.COM
;   a boot sector, for QEMU    nasm -dBOOT feed.asm -o feed.img

        cpu     8086

DATA    equ     3F8h            ; the UART of COM1
LATCH   equ     DATA            ; divisor of the baud rate, while bit 7 of CONTROL is set
CONTROL equ     DATA+3          ; line control
MODEM   equ     DATA+4          ; modem control
STATUS  equ     DATA+5          ; line status: bit 0 a character is here, bit 5 the next one may be sent
BAUD    equ     115200/9600
CR      equ     13
LF      equ     10
PATIENT equ     180             ; ticks of the BIOS clock, 55 ms each

%ifdef BOOT
        org     7C00h
        jmp     0:start         ; some BIOSes start a boot sector at 07C0:0000
%else
        org     100h
%endif

start:
%ifdef BOOT
        xor     ax, ax
        mov     ds, ax
        mov     ss, ax
        mov     sp, 7C00h
%endif
        sti
        cld
        mov     dx, CONTROL
        mov     al, 80h
        out     dx, al
        mov     dx, LATCH
        mov     ax, BAUD
        out     dx, al
        inc     dx
        mov     al, ah
        out     dx, al
        mov     dx, CONTROL
        mov     al, 7           ; 8 data bits, no parity, 2 stop bits
        out     dx, al
        inc     dx
        mov     al, 3           ; DTR and RTS on
        out     dx, al

knock:  mov     di, PATIENT     ; the interface measures the baud rate at a bracket, and answers U
.again: mov     al, '('
        call    send
        mov     bx, 2
        call    receive
        jnc     .heard
        dec     di
        jnz     .again
        jmp     silent
.heard: cmp     al, 'U'
        jne     .again
        call    rest            ; its carriage return

        mov     si, format
        call    say
        mov     bx, 2           ; up to 5 ms after this message characters are lost
        call    pause
        call    wait_idle       ; the answer comes when the ramp is calculated
        mov     si, move
        call    say
        call    wait_idle
        mov     si, position
        call    say
.print: call    receive_soon
        cmp     al, CR
        je      .done
        call    print
        jmp     .print
.done:  xor     bx, bx
        jmp     leave

; Request the state until it is not "executing"; any state but "completed" ends the program.
wait_idle:
        mov     si, state
        call    say
.reply: call    receive_soon
        push    ax
        call    rest
        pop     ax
        cmp     al, 'U'         ; the late answer to a bracket
        je      .reply
        cmp     al, 'E'
        je      wait_idle
        cmp     al, 'C'
        jne     fault
        ret

fault:  mov     si, refused
        jmp     fail
silent: mov     si, nobody
fail:   lodsb
        or      al, al
        jz      .done
        call    print
        jmp     fail
.done:  mov     bx, 1

; End with the exit code BL.
leave:  mov     al, CR
        call    print
        mov     al, LF
        call    print
%ifdef BOOT
        mov     al, bl
        out     0F4h, al        ; isa-debug-exit: QEMU ends with the exit code 2*AL+1
.halt:  hlt
        jmp     .halt
%else
        mov     ah, 4Ch
        mov     al, bl
        int     21h
%endif

; Print the character AL.
print:
%ifdef BOOT
        out     0E9h, al        ; debugcon
        push    bx
        mov     ah, 0Eh
        mov     bx, 7
        int     10h
        pop     bx
%else
        mov     ah, 2
        mov     dl, al
        int     21h
%endif
        ret

; Send the text at SI, which ends with a zero.
say:    lodsb
        or      al, al
        jz      done
        call    send
        jmp     say

; Send the character AL.
send:   mov     ah, al
        mov     dx, STATUS
.wait:  in      al, dx
        test    al, 20h
        jz      .wait
        mov     dx, DATA
        mov     al, ah
        out     dx, al
done:   ret

; Receive characters up to a carriage return.
rest:   call    receive_soon
        cmp     al, CR
        jne     rest
        ret

; Receive a character into AL; end the program if none comes.
receive_soon:
        mov     bx, PATIENT
        call    receive
        jc      silent
        ret

; Receive a character into AL within BX ticks; carry is set if none came.
receive:
        call    ticks
        mov     cx, ax
.wait:  mov     dx, STATUS
        in      al, dx
        test    al, 1
        jnz     .here
        call    ticks
        sub     ax, cx
        cmp     ax, bx
        jb      .wait
        stc
        ret
.here:  mov     dx, DATA
        in      al, dx
        clc
        ret

; Wait BX ticks.
pause:  call    ticks
        mov     cx, ax
.wait:  call    ticks
        sub     ax, cx
        cmp     ax, bx
        jb      .wait
        ret

; Return the clock of the BIOS in AX.
ticks:  push    bx
        push    cx
        push    dx
        xor     ax, ax
        int     1Ah
        mov     ax, dx
        pop     dx
        pop     cx
        pop     bx
        ret

format  db      'U61', CR, 0            ; 8 data bits, 2 stop bits, no parity
move    db      'X1000@2000$', CR, 0
state   db      'E', CR, 0
position db     'N', CR, 0
nobody  db      'no answer', 0
refused db      'fault', 0

%ifdef BOOT
        times   510-($-$$) db 0
        dw      0AA55h
%endif
